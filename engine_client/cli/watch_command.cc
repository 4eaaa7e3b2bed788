#include "engine_client/cli/watch_command.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/daemon/posterior_listing.h"
#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/stop_signal.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

struct WatchOptions {
  std::string daemon;
  std::string project;
  std::string scene;
  bool once = false;
  bool json = false;
};

constexpr char kLegend[] =
    "|: mean, -: central 95 % of the posterior, best: probability to be the best arm. Ctrl-C "
    "ends.\n";

int ShowOnce(const WatchOptions& options, Terminal& terminal) {
  const auto scenes = ListPosteriors(options.daemon, options.project, options.scene);
  if (!scenes.ok()) return Fail(terminal, scenes.status());
  if (options.json) {
    nlohmann::ordered_json document = {{"command", "watch"},
                                       {"daemon", options.daemon},
                                       {"scenes", nlohmann::ordered_json::array()}};
    for (const v1::ScenePosterior& scene : *scenes) {
      document["scenes"].push_back(PosteriorJson(scene));
    }
    PrintJson(document, terminal.out);
    return kDone;
  }
  for (const v1::ScenePosterior& scene : *scenes) terminal.out << PosteriorText(scene) << '\n';
  if (scenes->empty()) terminal.out << "The daemon has no posteriors of this yet\n";
  return kDone;
}

// What is on the screen: every scene's latest posterior and the latest decisions. On a terminal it
// is drawn anew at most five times a second; elsewhere each event is printed as it comes.
class Screen {
 public:
  Screen(std::ostream& out, bool redraw) : out_(out), redraw_(redraw) {}

  void Show(const v1::WatchPosteriorsResponse& event) {
    if (event.has_posterior()) {
      const v1::ScenePosterior& scene = event.posterior();
      scenes_[{scene.project(), scene.scene(), scene.machine_class(), scene.reward_version()}] =
          scene;
      if (!redraw_) out_ << PosteriorText(scene) << std::flush;
    } else if (event.has_decision()) {
      decisions_.push_back(DecisionText(event.decision()));
      if (decisions_.size() > kDecisionMax) decisions_.pop_front();
      if (!redraw_) out_ << decisions_.back() << std::endl;
    }
    const auto now = std::chrono::steady_clock::now();
    if (redraw_ && now - drawn_at_ >= std::chrono::milliseconds(200)) {
      drawn_at_ = now;
      Draw();
    }
  }

 private:
  static constexpr size_t kDecisionMax = 10;

  void Draw() {
    out_ << "\x1b[H\x1b[2J" << kLegend << '\n';
    for (const auto& [key, scene] : scenes_) out_ << PosteriorText(scene) << '\n';
    for (const std::string& decision : decisions_) out_ << decision << '\n';
    out_ << std::flush;
  }

  std::ostream& out_;
  const bool redraw_;
  std::map<std::tuple<std::string, std::string, std::string, uint32_t>, v1::ScenePosterior> scenes_;
  std::deque<std::string> decisions_;
  std::chrono::steady_clock::time_point drawn_at_;
};

int WatchLive(const WatchOptions& options, Terminal& terminal) {
  const auto channel = OpenChannel(options.daemon);
  if (!channel.ok()) return Fail(terminal, channel.status());
  const auto stub = v1::PosteriorsService::NewStub(*channel);
  v1::WatchPosteriorsRequest request;
  request.set_project(options.project);
  request.set_scene(options.scene);
  grpc::ClientContext context;
  const auto reader = stub->WatchPosteriors(&context, request);
  InstallStopSignal();
  std::atomic<bool> ended = false;
  // Reading blocks, so Ctrl-C is looked for elsewhere.
  std::thread canceller([&] {
    while (!ended && !StopRequested()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    context.TryCancel();
  });
  Screen screen(terminal.out, isatty(STDOUT_FILENO) == 1);
  v1::WatchPosteriorsResponse event;
  while (reader->Read(&event)) screen.Show(event);
  ended = true;
  canceller.join();
  const grpc::Status status = reader->Finish();
  if (StopRequested()) return kDone;
  return Fail(terminal, status.ok() ? Status(StatusCode::kUnavailable,
                                             "the daemon at " + options.daemon + " ended the watch")
                                    : ToStatus(status, options.daemon));
}

}  // namespace

void AddWatchCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<WatchOptions>(
      app, "watch", "Show a daemon's posteriors and decisions, live",
      "  sweepstake watch --daemon 127.0.0.1:7433\n"
      "  sweepstake watch --daemon 127.0.0.1:7433 --scene hurricane-3000\n"
      "  sweepstake watch --daemon 127.0.0.1:7433 --json      once, for machines\n"
      "95_low to 95_high is the central 95 % of an arm's posterior, best its probability to be "
      "the\n"
      "best arm. Verdicts: stable (best >= 0.8), tie (below, but choosing the leader loses at "
      "most\n"
      "0.5 % of the reward), ambiguous; a session's decisions say degraded where even the leader\n"
      "misses the frame-rate floor. Exit code 3 when no daemon answers.",
      exit_code,
      [](CLI::App& command, WatchOptions& options) {
        command.add_option("--daemon", options.daemon, "Address of sweepstaked, HOST:PORT")
            ->required();
        command.add_option("--project", options.project, "Only this project");
        command.add_option("--scene", options.scene, "Only this scene");
        command.add_flag("--once", options.once, "Show what there is now, and end");
        command.add_flag("--json", options.json, "One JSON document on stdout; implies --once");
      },
      [&terminal](const WatchOptions& options) {
        return options.once || options.json ? ShowOnce(options, terminal)
                                            : WatchLive(options, terminal);
      });
}

}  // namespace sweepstake::cli
