// A load on a daemon: thousands of streams that send batches of frames at a fixed rate, and what
// comes of it.
//
// RunLoad blocks: its thread is the one timer of all streams. How late that timer is is measured as
// a figure of its own, because a generator that cannot keep its rate says nothing about the daemon.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct LoadPlan {
  static constexpr uint64_t kMaxStreamsPerChannel = 100;  // the daemon lets further ones wait

  DaemonOptions daemon;
  std::string project = "load";
  uint64_t stream_count = 1000;
  uint64_t channel_count = 0;  // connections; 0: as few as can carry the streams
  uint64_t scene_count = 10;   // the streams take turns with them
  double batches_per_second = 1;
  uint32_t batch_frames = 60;
  uint64_t duration_ns = 30'000'000'000;  // from the moment when all streams have begun
  // How long the last acknowledgements are waited for: a daemon gives one every two seconds.
  uint64_t commit_patience_ns = 2'500'000'000;
  double bail_out_share = 0.01;  // of the batches
  int64_t server_pid = 0;        // of the daemon, where it runs here; 0: unknown
};

struct LoadResult {
  uint64_t welcome_count = 0;   // streams that got a welcome, again after a loss
  uint64_t batch_count = 0;     // sent while measuring or before
  uint64_t bail_out_count = 0;  // sent
  uint64_t switch_count = 0;    // commands received, and outcomes sent
  uint64_t unsent_count = 0;    // batches that were due while a stream was not connected or behind
  uint64_t rejected_count = 0;  // connections that the daemon refused or ended with an error
  uint64_t finished_count = 0;  // sessions whose goodbye was answered
  uint64_t measured_batch_count = 0;
  uint64_t acknowledged_count = 0;  // messages sent while measuring, on the daemon's disk
  double measured_s = 0;
  std::vector<double> hello_latency_ms;     // sorted; from a connection begun to its welcome
  std::vector<double> decision_latency_ms;  // sorted
  // Sorted; from a batch that was sent while measuring to its acknowledgement.
  std::vector<double> commit_lag_ms;
  std::vector<double> tick_lateness_ms;   // sorted
  std::optional<double> reconnect_s;      // the longest time until all streams were back
  std::optional<double> server_cpu_s;     // while measuring
  std::optional<double> generator_cpu_s;  // this process's, while measuring
  // kUnavailable if sessions did not finish, with the last error; a run that was stopped before all
  // had begun is ok without one.
  Status shortfall;
};

// Errors: kInvalidArgument (an option, or the daemon says that one is not valid), kUnavailable
// (nobody answered, or the daemon refused every stream).
// `progress` is called about once a second.
Result<LoadResult> RunLoad(const LoadPlan& plan, const std::function<bool()>& stop,
                           const std::function<void(const std::string&)>& progress);

}  // namespace sweepstake::cli
