// `sweepstake-lab load`: thousands of made-up games on one daemon, and how it bears them.
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/stop_signal.h"
#include "tests/laboratory/laboratory.h"
#include "tests/laboratory/load/load_summary.h"

namespace sweepstake::cli {
namespace {

struct LoadOptions {
  LoadPlan plan;
  std::string duration = "30s";
  bool json = false;
};

int Run(const LoadOptions& options, Terminal& terminal) {
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
  command.add_option("--streams", plan.stream_count, "Games at a time")
      ->check(WholeFrom(1, 100'000))
      ->capture_default_str();
  command
      .add_option("--rate", plan.batches_per_second,
                  "Batches a second of each game; a daemon ends one with more than its "
                  "--max-messages-per-s")
      ->check(RealFrom(0.01, 1000))
      ->capture_default_str();
  command.add_option("--frames-per-batch", plan.batch_frames, "Frames in a batch")
      ->check(WholeFrom(1, 240))
      ->capture_default_str();
  command.add_option("--duration", options.duration, "How long to measure, once all have begun")
      ->capture_default_str();
  command.add_option("--project", plan.project, "Project that what the games send is learnt under")
      ->capture_default_str();
  command
      .add_option("--channels", plan.channel_count,
                  "Connections; 0 takes one for each 100 streams, which is what one can carry")
      ->check(WholeUpTo(10'000))
      ->capture_default_str();
  command.add_option("--scenes", plan.scene_count, "Scenes that the games take turns with")
      ->check(WholeFrom(1, 100'000))
      ->capture_default_str();
  command
      .add_option("--bail-out-share", plan.bail_out_share,
                  "Share of the batches that a bail-out follows")
      ->check(RealFrom(0, 1))
      ->capture_default_str();
  command
      .add_option("--server-pid", plan.server_pid,
                  "The daemon's process, where it runs on this machine, for its CPU time")
      ->check(WholeUpTo(1u << 30));
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddLoadCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<LoadOptions>(
      app, "load", "Load a daemon with thousands of made-up games",
      "  sweepstake-lab load --daemon 127.0.0.1:7433 --streams 1000 --duration 30s\n"
      "  sweepstake-lab load --daemon 127.0.0.1:7433 --streams 10000 --server-pid PID --json\n"
      "batches_per_s were given to gRPC, acknowledged_per_s of the messages of that time "
      "(bail-outs\n"
      "and switches, too) reached the daemon's disk, at most 2.5 s after its end: where that is "
      "less,\n"
      "the daemon does not keep up.\n"
      "hello_latency is the time from a connection begun to its welcome, decision_latency the one\n"
      "from a bail-out sent to its switch command, commit_lag the one from a batch sent to the "
      "word\n"
      "that it is on the daemon's disk, tick_lateness how late this program's own timer was: "
      "where\n"
      "that is large, the other figures are not the daemon's. Ctrl-C ends the run early.\n"
      "Exit code 3 when no daemon answers, or when games were refused or lost at the end.",
      exit_code, Declare,
      [&terminal](const LoadOptions& options) { return Run(options, terminal); });
}

}  // namespace sweepstake::cli
