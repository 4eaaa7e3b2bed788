// Puts load on a daemon: thousands of streams send batches of frames at a fixed rate. Measures
// rates, latencies and errors.
//
// RunLoad blocks: its thread is the only timer of all streams. The lateness of this timer is also
// measured: if the generator cannot keep its rate, the figures about the daemon are not valid.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct LoadPlan {
  static constexpr uint64_t kMaxStreamsPerChannel = 100;  // the daemon queues further streams

  DaemonOptions daemon;
  std::string project = "load";
  uint64_t stream_count = 1000;
  uint64_t scene_count = 10;  // assigned to the streams in turn
  double batches_per_second = 1;
  uint32_t batch_frames = 60;
  uint64_t duration_ns = 30'000'000'000;  // measured time, which begins when all streams have begun
  // Maximum wait for the last acknowledgements. A daemon sends one every two seconds.
  uint64_t commit_patience_ns = 2'500'000'000;
  double bail_out_share = 0.01;  // share of the batches that a bail-out follows
  int64_t server_pid = 0;        // process id of the daemon if it runs on this machine; 0: unknown
};

struct LoadResult {
  uint64_t welcome_count = 0;   // welcomes received, including those after a reconnection
  uint64_t batch_count = 0;     // batches sent, including those before the measurement
  uint64_t bail_out_count = 0;  // bail-outs sent
  uint64_t switch_count = 0;    // switch commands received and answered
  uint64_t unsent_count = 0;    // batches not sent: no connection, or too many are waiting
  uint64_t rejected_count = 0;  // connections that the daemon refused or ended with an error
  uint64_t finished_count = 0;  // sessions whose goodbye was answered
  uint64_t measured_batch_count = 0;
  uint64_t acknowledged_count = 0;  // measured messages that are on the daemon's disk
  double measured_s = 0;
  std::vector<double> hello_latency_ms;  // sorted; from the start of a connection to its welcome
  // Sorted; from a bail-out to the switch command that answers it.
  std::vector<double> decision_latency_ms;
  // Sorted; the time from sending a measured batch to its acknowledgement.
  std::vector<double> commit_lag_ms;
  std::vector<double> tick_lateness_ms;  // sorted; how late the timer sent a batch
  // The longest time from a loss until all streams were connected again.
  std::optional<double> reconnect_s;
  std::optional<double> server_cpu_s;     // CPU time of the daemon while measuring
  std::optional<double> generator_cpu_s;  // CPU time of this process while measuring
  // kUnavailable with the last error if sessions did not finish. Ok if the run was stopped before
  // all streams had begun and there was no error.
  Status shortfall;
};

// Runs the load. Calls `progress` about once a second. Errors: kInvalidArgument (this function or
// the daemon rejects an option), kUnavailable (no daemon answered, or the daemon refused every
// stream).
Result<LoadResult> RunLoad(const LoadPlan& plan, const std::function<bool()>& stop,
                           const std::function<void(const std::string&)>& progress);

// Return the measured figures as a JSON document, and as a table with one figure per line.
nlohmann::ordered_json LoadJson(const LoadPlan& plan, const LoadResult& result);
std::string LoadText(const LoadPlan& plan, const LoadResult& result);

}  // namespace sweepstake::cli
