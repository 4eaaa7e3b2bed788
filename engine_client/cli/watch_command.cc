// `sweepstake watch`: shows a daemon's posteriors and decisions as they change.
#include <nlohmann/json.hpp>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/daemon/watch_screen.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/process.h"

namespace sweepstake::cli {
namespace {

struct WatchOptions {
  DaemonOptions daemon;
  std::string project;
  std::string scene;
  bool once = false;
  bool json = false;
  bool follow = false;
};

int ShowOnce(const WatchOptions& options, Terminal& terminal) {
  const auto scenes = ListPosteriors(options.daemon, options.project, options.scene);
  if (!scenes.ok()) return FailAnswer(terminal, scenes.status());
  const nlohmann::ordered_json document = {{"command", "watch"},
                                           {"daemon", options.daemon.address},
                                           {"scenes", PosteriorsJson(*scenes)}};
  PrintResult(terminal, options.json, document, PosteriorsText(*scenes));
  return kDone;
}

void PrintEvent(const v1::WatchPosteriorsResponse& event, std::ostream& out) {
  if (event.has_posterior())
    PrintJson({{"posterior", PosteriorJson(event.posterior())}}, out, /*indent=*/-1);
  for (const v1::DecisionEvent& decision : event.decisions())
    PrintJson({{"decision", DecisionJson(decision)}}, out, /*indent=*/-1);
  out.flush();
}

int WatchLive(const WatchOptions& options, Terminal& terminal) {
  InstallStopSignal();
  WatchScreen screen(terminal.out, terminal.out_is_tty);
  const Status status = WatchPosteriors(
      options.daemon, options.project, options.scene,
      [&] {
        screen.Redraw();
        return StopRequested();
      },
      [&](const v1::WatchPosteriorsResponse& event) {
        if (!options.json) return screen.Show(event);
        PrintEvent(event, terminal.out);
      },
      [&](const Status& connection) {
        connection.ok() ? screen.DrawAgain() : screen.Restart();
        SayConnection(terminal, connection);
      });
  return status.ok() ? kDone : FailAnswer(terminal, status);
}

}  // namespace

void AddWatchCommand(const CommandContext& context) {
  AddCommand<WatchOptions>(
      context, "watch", "Show a daemon's posteriors and decisions, live",
      "  sweepstake watch --daemon 127.0.0.1:7433\n"
      "  sweepstake watch --daemon 127.0.0.1:7433 --scene hurricane-3000\n"
      "  sweepstake watch --daemon 127.0.0.1:7433 --json      once, for programs\n"
      "  sweepstake watch --daemon 127.0.0.1:7433 --json --follow\n"
      "  sweepstake watch --daemon daemon.example:7433 --tls-ca ca.pem\n"
      "95_low to 95_high: the central 95 % of an arm's posterior, and of its cost divided by the\n"
      "leader's. best: the probability of being the best arm, as if all windows were independent.\n"
      "For the session of the latest decision: live and lane, the live windows and shadow-lane\n"
      "visits in its evidence; equiv, the number of live windows that would be as informative\n"
      "as all its evidence. It is a fraction if an arm was measured mostly by the lane. Verdicts: "
      "stable\n"
      "(best >= 0.8), tie (less, but choosing the leader loses at most 0.5 %), ambiguous\n"
      "(it may lose more). A decision can also be degraded: even the leader misses the frame-rate\n"
      "floor. Exit code 3 if no daemon answers; a daemon that is lost later is tried again until\n"
      "Ctrl-C.",
      [](CLI::App& command, WatchOptions& options) {
        AddDaemonOptions(command, options.daemon);
        command.add_option("--project", options.project, "Only this project");
        command.add_option("--scene", options.scene, "Only this scene");
        command.add_flag("--once", options.once, "Show the current state once, and exit");
        CLI::Option* json =
            command.add_flag("--json", options.json, "One JSON document on stdout; implies --once");
        command
            .add_flag("--follow", options.follow,
                      "With --json: one document per line for every change and decision, live")
            ->needs(json);
      },
      [](const WatchOptions& options, Terminal& terminal) {
        const bool once = options.once || (options.json && !options.follow);
        return once ? ShowOnce(options, terminal) : WatchLive(options, terminal);
      });
}

}  // namespace sweepstake::cli
