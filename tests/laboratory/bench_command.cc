#include "tests/laboratory/laboratory.h"

#include <array>
#include <memory>
#include <sstream>

#include "engine_client/cli/game/scene_choice.h"
#include "tests/laboratory/bench/bench_output.h"
#include "tests/laboratory/bench/bench_run.h"
#include "tests/laboratory/io/report_file.h"

namespace sweepstake::cli {
namespace {

Status WriteReport(const BenchReport& report, ReportFile& file, Terminal& terminal) {
  std::ostringstream json;
  PrintBenchJson(report, json);
  return file.Commit(std::array{json.str()}, terminal);
}

int Bench(const BenchOptions& options, Terminal& terminal) {
  std::unique_ptr<ReportFile> file;
  if (options.report_file) {
    auto created = ReportFile::Create(*options.report_file);
    if (!created.ok()) return Fail(terminal, created.status());
    file = std::move(*created);
  }
  const auto report = RunBench(options, Progress(terminal, "bench").OnShare());
  if (!report.ok()) return Fail(terminal, report.status());
  if (options.json) {
    PrintBenchJson(*report, terminal.out);
  } else {
    PrintBenchTables(*report, terminal.out);
  }
  if (file) {
    if (Status status = WriteReport(*report, *file, terminal); !status.ok())
      return Fail(terminal, status);
  }
  return AnyDiffers(*report) ? kCheckFailed : kDone;
}

void Declare(CLI::App& command, BenchOptions& options) {
  command
      .add_option("--scene", options.scenes,
                  "Scenes or .aabbs files, or all, changing, degenerate, mixtures")
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
  command.add_option("--seed", options.seed, "Seed of the scenes")
      ->check(NotNegative())
      ->capture_default_str();
  command.add_option("--arms", options.arms, "all, or names of backends")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--threads", options.thread_counts, "Threads of each arm, counted one by one")
      ->delimiter(',')
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  command.add_flag("--cold", options.cold,
                   "Evict the caches before each frame by reading and writing 32 MiB");
  command
      .add_option(
          "--simd", options.simd,
          "all, or instruction sets, as avx512, avx2 or sse4: times each arm with each of them; "
          "peers choose their own. SWEEPSTAKE_CLIENT_SIMD sets one for every command")
      ->delimiter(',');
  command.add_flag("--peers", options.peers,
                   "Time the broad phases of other libraries too, and compare");
  command
      .add_option("--peer-cap", options.peer_cap_s,
                  "Maximum seconds of a peer in one scene with one object count")
      ->check(RealFrom(0.001, 86'400.0))
      ->capture_default_str();
  command.add_flag("--json", options.json, "One JSON document on stdout");
  command.add_option("--report", options.report_file,
                     "Charts and tables as one HTML file that needs no network");
}

}  // namespace

void AddBenchCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                     int& exit_code) {
  AddCommand<BenchOptions>(
      app, "bench", "Time every arm on the same frames: take all boxes, find all pairs",
      "  sweepstake-lab bench --scene suite-b,suite-g,suite-h --objects 1000,10000 --arms all\n"
      "  sweepstake-lab bench --scene hurricane --objects 3000 --arms SAP,KDTree --json\n"
      "  sweepstake-lab bench --scene nearly-resting,beams --objects 10000 --threads 1,2\n"
      "  sweepstake-lab bench --scene suite-b --objects 1000,10000 --peers --report out.html\n"
      "  sweepstake-lab bench --scene suite-b --objects 10000 --simd avx512,avx2,sse4\n"
      "Times are milliseconds per frame. Pairs and AABB checks are means per frame; bytes are the "
      "maximum.\n" +
          SceneHelp(),
      exit_code, Declare, [&terminal, command_line](const BenchOptions& options) {
        BenchOptions given = options;
        given.command_line = command_line;
        return Bench(given, terminal);
      });
}

}  // namespace sweepstake::cli
