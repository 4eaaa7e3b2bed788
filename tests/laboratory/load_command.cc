// `sweepstake-lab load`: thousands of simulated games on one daemon, with the daemon's rates and
// latencies.
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/process.h"
#include "tests/laboratory/laboratory.h"
#include "tests/laboratory/load/load_run.h"

namespace sweepstake::cli {
namespace {

struct LoadOptions {
  LoadPlan plan;
  std::string duration = "30s";
  bool json = false;
};

int LoadDaemon(const LoadOptions& options, Terminal& terminal) {
  LoadPlan plan = options.plan;
  const auto duration_ns = ParseDuration(options.duration);
  if (!duration_ns.ok()) return Fail(terminal, duration_ns.status());
  plan.duration_ns = *duration_ns;
  InstallStopSignal();
  Progress progress(terminal, "load", 0);
  const auto result =
      RunLoad(plan, StopRequested, [&](const std::string& text) { progress.Show(0, text); });
  progress.ClearBar();
  if (!result.ok()) return FailAnswer(terminal, result.status());
  nlohmann::ordered_json document = {{"command", "load"}, {"daemon", plan.daemon.address}};
  document.update(LoadJson(plan, *result));
  PrintResult(terminal, options.json, document, LoadText(plan, *result));
  return result->shortfall.ok() ? kDone : Fail(terminal, result->shortfall);
}

void Declare(CLI::App& command, LoadOptions& options) {
  LoadPlan& plan = options.plan;
  AddDaemonOptions(command, plan.daemon);
  command.add_option("--streams", plan.stream_count, "Games that play at the same time")
      ->check(WholeFrom(1, 100'000));
  command
      .add_option("--rate", plan.batches_per_second,
                  "Batches per second of each game; a daemon ends a game that exceeds its "
                  "--max-messages-per-s")
      ->check(RealFrom(0.01, 1000));
  command.add_option("--frames-per-batch", plan.batch_frames, "Frames in a batch")
      ->check(WholeFrom(1, 240));
  command.add_option("--duration", options.duration, "Measured time after all games have begun");
  command.add_option("--project", plan.project, "Project name that the games send");
  command.add_option("--scenes", plan.scene_count, "Number of scenes; the games use them in turn")
      ->check(WholeFrom(1, 100'000));
  command
      .add_option("--bail-out-share", plan.bail_out_share,
                  "Share of the batches that are followed by a bail-out, from 0 to 1")
      ->check(RealFrom(0, 1));
  command
      .add_option("--server-pid", plan.server_pid,
                  "Process id of a daemon on this machine, to measure its CPU time")
      ->check(WholeUpTo(1u << 30));
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddLoadCommand(const CommandContext& context) {
  AddCommand<LoadOptions>(
      context, "load", "Load a daemon with thousands of simulated games",
      "  sweepstake-lab load --daemon 127.0.0.1:7433 --streams 1000 --duration 30s\n"
      "  sweepstake-lab load --daemon 127.0.0.1:7433 --streams 10000 --server-pid PID --json\n"
      "batches_per_s counts batches that were passed to gRPC. acknowledged_per_s counts messages\n"
      "(batches, bail-outs, switches) of the measurement whose acknowledgement arrived at most\n"
      "2.5 s after its end. If the second figure is lower, the daemon does not keep up.\n"
      "hello_latency is the time from the start of a connection to its welcome message,\n"
      "decision_latency from a bail-out to its switch command, commit_lag from a batch to the\n"
      "acknowledgement that it is on disk. tick_lateness is the delay of this program's timer. If\n"
      "it is large, the other figures do not describe the daemon. Ctrl-C ends the run early.\n"
      "The exit code is 3 if no daemon answers, or if games were refused or lost at the end.",
      Declare, LoadDaemon);
}

}  // namespace sweepstake::cli
