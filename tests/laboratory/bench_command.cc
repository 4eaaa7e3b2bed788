#include "tests/laboratory/laboratory.h"

#include "tests/laboratory/bench/bench_report.h"

namespace sweepstake::cli {
namespace {

int Bench(const BenchOptions& options, Terminal& terminal) {
  const auto report = RunBench(options, Progress(terminal, "bench").OnShare());
  if (!report.ok()) return Fail(terminal, report.status());
  if (options.json) {
    PrintBenchJson(*report, terminal.out);
  } else {
    PrintBenchTable(*report, terminal.out);
  }
  return AnyDiffers(*report) ? kCheckFailed : kDone;
}

void Declare(CLI::App& command, BenchOptions& options) {
  AddSceneOptions(command, options.scenes, options.object_counts)->required();
  AddArmsOption(command, options.arms);
  command.add_option("--frames", options.frames, "Measured frames")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}));
  command.add_option("--warmup", options.warmup, "Frames that run before the measured ones")
      ->check(WholeUpTo(1'000'000));
  AddSeedOption(command, options.seed, "the scenes");
  command
      .add_option("--threads", options.thread_counts,
                  "Thread counts; every arm is timed with each of them")
      ->delimiter(',')
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}));
  command.add_flag("--cold", options.cold,
                   "Evict the caches before each frame by reading and writing 32 MiB");
  command
      .add_option(
          "--simd", options.simd,
          "Instruction sets, such as avx512, avx2 or sse4, or all; every arm is timed with each "
          "of them. Peers choose their own. The variable SWEEPSTAKE_CLIENT_SIMD selects one for "
          "any command")
      ->delimiter(',');
  command.add_flag("--peers", options.peers,
                   "Also time the broad phases of other libraries (peers), and compare");
  command
      .add_option("--peer-cap", options.peer_cap_s,
                  "Seconds after which a peer is stopped, per scene and object count")
      ->check(RealFrom(0.001, 86'400.0));
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddBenchCommand(const CommandContext& context) {
  AddCommand<BenchOptions>(
      context, "bench", "Time every arm on the same frames: update all boxes, find all pairs",
      "  sweepstake-lab bench --scene suite-b,suite-g,suite-h --objects 1000,10000 --arms all\n"
      "  sweepstake-lab bench --scene hurricane --objects 3000 --arms SAP,KDTree --json\n"
      "  sweepstake-lab bench --scene nearly-resting,beams --objects 10000 --threads 1,2\n"
      "  sweepstake-lab bench --scene suite-b --objects 1000,10000 --peers --json > bench.json\n"
      "  sweepstake-lab bench --scene suite-b --objects 10000 --simd avx512,avx2,sse4\n"
      "Times are milliseconds per frame. Pairs and AABB checks are means per frame; bytes are the "
      "maximum.\n" +
          SceneHelp(),
      Declare,
      [command_line = context.command_line](const BenchOptions& options, Terminal& terminal) {
        BenchOptions given = options;
        given.command_line = command_line;
        return Bench(given, terminal);
      });
}

}  // namespace sweepstake::cli
