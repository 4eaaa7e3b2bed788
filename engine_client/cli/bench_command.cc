#include "engine_client/cli/bench_command.h"

#include "engine_client/cli/bench_output.h"
#include "engine_client/cli/bench_run.h"
#include "engine_client/cli/scene_choice.h"

namespace sweepstake::cli {
namespace {

int Bench(const BenchOptions& options, Terminal& terminal) {
  const auto report = RunBench(options, terminal);
  if (!report.ok()) return Fail(terminal, report.status());
  if (options.json) {
    PrintBenchJson(*report, terminal.out);
  } else {
    PrintBenchTables(*report, terminal.out);
  }
  return AnyDiffers(*report) ? kCheckFailed : kDone;
}

void Declare(CLI::App& command, BenchOptions& options) {
  command
      .add_option("--scene", options.scenes, "Scenes or .aabbs files, or all, degenerate, mixtures")
      ->delimiter(',')
      ->required();
  command.add_option("--objects", options.object_counts, "Object counts")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--frames", options.frames, "Measured frames")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}))
      ->capture_default_str();
  command.add_option("--warmup", options.warmup, "Frames before them")
      ->check(WholeUpTo(1'000'000))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of the scenes")->capture_default_str();
  command.add_option("--arms", options.arms, "all, or names of backends")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--threads", options.thread_counts, "Threads of each arm, counted one by one")
      ->delimiter(',')
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  command.add_flag("--peers", options.peers,
                   "Time the broad phases of other libraries too, and compare");
  command
      .add_option("--peer-cap", options.peer_cap_s,
                  "Seconds a peer may take in one scene with one count; it then stops")
      ->check(CLI::Range(0.001, 86'400.0))
      ->capture_default_str();
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddBenchCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<BenchOptions>(
      app, "bench", "Time every arm on the same frames: take all boxes, find all pairs",
      "  sweepstake bench --scene suite-b,suite-g,suite-h --objects 1000,10000 --arms all\n"
      "  sweepstake bench --scene hurricane --objects 3000 --arms SAP,KDTree --json\n"
      "  sweepstake bench --scene nearly-resting,beams --objects 10000 --threads 1,2\n"
      "  sweepstake bench --scene suite-b --objects 1000,10000 --peers\n"
      "Milliseconds per frame; pairs and AABB checks are means per frame, bytes the most held.\n" +
          SceneHelp(),
      exit_code, Declare,
      [&terminal](const BenchOptions& options) { return Bench(options, terminal); });
}

}  // namespace sweepstake::cli
