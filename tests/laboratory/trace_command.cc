#include "tests/laboratory/laboratory.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/whole_file.h"
#include "tests/laboratory/trace/trace_run.h"
#include "tests/laboratory/trace/trace_summary.h"

namespace sweepstake::cli {
namespace {

namespace fs = std::filesystem;
constexpr uint32_t kMaxFrames = 200'000;

struct TraceCommandOptions {
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts{1000};
  uint64_t seed = 1;
  uint32_t frames = 3000;
  uint32_t repeats = 5;
  std::vector<std::string> arms{"all"};
  std::string out;
  std::vector<std::string> costs;
  bool json = false;
};

// One trace and the path of its file, which may not exist yet.
struct TraceJob {
  SceneChoice scene;
  std::string file;
};

Status Invalid(const std::string& message) { return {StatusCode::kInvalidArgument, message}; }

Status CheckWords(const TraceCommandOptions& options) {
  if (options.scenes.empty() == options.costs.empty()) {
    return Invalid("give --scene to trace a scene, or --costs to show a trace");
  }
  if (options.scenes.empty() != options.out.empty()) {
    return Invalid("--scene needs --out FILE.costs, and --costs must be without --out");
  }
  return {};
}

// Returns the jobs. The file of a job is SCENE-OBJECTS-SEED.costs in the folder --out, or --out
// itself for a single trace.
std::vector<TraceJob> JobsOf(const TraceCommandOptions& options) {
  std::vector<TraceJob> jobs;
  for (const std::string& file : options.costs) {
    jobs.emplace_back();
    jobs.back().file = file;
  }
  const auto choices = ExpandScenes(options.scenes, options.object_counts, options.seed);
  for (const SceneChoice& choice : choices) {
    const std::string name = fs::path(choice.name).stem().string() + "-" +
                             std::to_string(choice.object_count) + "-" +
                             std::to_string(choice.seed) + ".costs";
    const bool is_file = choices.size() == 1 && options.out.ends_with(".costs");
    jobs.push_back({choice, is_file ? options.out : (fs::path(options.out) / name).string()});
  }
  return jobs;
}

// Checks, before anything is measured, that every file can be written and every scene opened.
Status CheckPlaces(const TraceCommandOptions& options, const std::vector<TraceJob>& jobs) {
  if (options.scenes.empty()) return {};
  if (jobs.size() > 1 && options.out.ends_with(".costs")) {
    return Invalid("--out must be a folder if there are several traces, one file each");
  }
  if (jobs.size() > 1 || !options.out.ends_with(".costs")) {
    std::error_code told_below;
    fs::create_directories(options.out, told_below);
  }
  for (const TraceJob& job : jobs) {
    if (const auto file = WholeFile::Create(job.file); !file.ok()) return file.status();
    if (const auto scene = OpenScene(job.scene); !scene.ok()) return scene.status();
  }
  return {};
}

Result<CostTrace> Measure(const TraceCommandOptions& options, const TraceJob& job,
                          const std::vector<std::string>& arms, Terminal& terminal) {
  Progress progress(terminal, "trace");
  const std::string label =
      job.scene.name + ", " + std::to_string(job.scene.object_count) + " objects";
  auto trace =
      RunTrace({job.scene, arms, options.frames, options.repeats},
               [&, show = OnShareWithTimeLeft(progress)](double share) { show(share, label); });
  if (!trace.ok()) return trace;
  if (const Status status = WriteCosts(job.file, *trace); !status.ok()) return status;
  return trace;
}

int Trace(const TraceCommandOptions& options, Terminal& terminal) {
  const std::vector<TraceJob> jobs = JobsOf(options);
  if (const Status status = CheckWords(options); !status.ok()) return Fail(terminal, status);
  const auto arms = ChooseArms(options.arms);
  if (!arms.ok()) return Fail(terminal, arms.status());
  if (const Status status = CheckPlaces(options, jobs); !status.ok()) return Fail(terminal, status);
  Json rows = Json::array();
  for (const TraceJob& job : jobs) {
    const auto trace =
        options.scenes.empty() ? ReadCosts(job.file) : Measure(options, job, *arms, terminal);
    if (!trace.ok()) return Fail(terminal, trace.status());
    const TraceSummary summary = SummarizeTrace(*trace);
    if (options.json) {
      rows.push_back(TraceJson(*trace, summary, job.file));
    } else {
      PrintTrace(*trace, summary, job.file, terminal.out);
    }
    PrintControlWarning(*trace, summary, terminal.err);
  }
  if (options.json) PrintJson({{"command", "trace"}, {"rows", std::move(rows)}}, terminal.out);
  return kDone;
}

void Declare(CLI::App& command, TraceCommandOptions& options) {
  AddSceneOptions(command, options.scenes, options.object_counts);
  AddArmsOption(command, options.arms);
  command.add_option("--frames", options.frames, "Frames of the trace")
      ->check(CLI::Range(kBurstFrames, kMaxFrames));
  AddSeedOption(command, options.seed, "the scenes");
  command
      .add_option("--repeats", options.repeats,
                  "Runs of the scene; the trace contains the lower quartiles over the runs, to "
                  "exclude disturbances")
      ->check(CLI::Range(uint32_t{1}, uint32_t{99}));
  command.add_option("--out", options.out,
                     "File to write, or a folder if there are several scenes or object counts");
  command.add_option("--costs", options.costs, "Show these traces instead of making one")
      ->delimiter(',');
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddTraceCommand(const CommandContext& context) {
  AddCommand<TraceCommandOptions>(
      context, "trace", "Time every arm on every frame of a scene, for `sweepstake-lab replay`",
      "  sweepstake-lab trace --scene hurricane --objects 3000 --out hurricane.costs\n"
      "  sweepstake-lab trace --scene brownian,suite-g --objects 1000,10000 --out traces/ --json\n"
      "  sweepstake-lab trace --costs b.costs\n"
      "All arms run the same frames in turns. One arm also runs with a second data structure: the\n"
      "A/A control, which shows the noise. Every 60 frames new data structures run a burst of\n"
      "frames, to measure the cost of a switch. An arm 16 times as slow as the cheapest one is\n"
      "measured on one frame in 20 or fewer; the other frames repeat its last time.\n" +
          SceneHelp(),
      Declare, Trace);
}

}  // namespace sweepstake::cli
