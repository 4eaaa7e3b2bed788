// One live run of an experiment: a real GameRun with the embedded decider, from Beta(1,1), through
// the exploration and the observation window; then every arm alone on the same scene as a control.
//
// Uses the calling thread as the frame thread, and the session's sender thread. Frames are not
// paced.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/experiment/experiment_plan.h"
#include "engine_client/cli/experiment/experiment_record.h"
#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct LiveOptions {
  uint64_t window_ns = 0;  // of real time
  double time_scale = 1;
  std::filesystem::path frames_file;  // every frame's metrics as CSV; empty: none
  // Called between frames with the real time since the run began. Returns whether to go on.
  std::function<bool(uint64_t elapsed_ns)> go_on;
};

// Absent: go_on said no. The errors of OpenScene, MakeEmbeddedSession and CsvFile; kInternal: the
// exploration takes ten times as long as it should.
Result<std::optional<RunRecord>> PlayLive(const PlannedRun& planned, const LiveOptions& options);

// Thins frames to windows: means and extremes of the frames that ran on one arm within an interval.
// Not thread-safe. Appends one window per interval and per change of arm.
class MetricWindowMeter {
 public:
  // REQUIRES: interval_ns > 0.
  explicit MetricWindowMeter(uint64_t interval_ns) : interval_ns_(interval_ns) {}

  // `now_ns` since the run began, at the frame's end.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // The windows, the running one included.
  std::vector<MetricWindow> Take(uint64_t now_ns);

 private:
  void Close(uint64_t now_ns);

  const uint64_t interval_ns_;
  uint64_t begin_ns_ = 0;
  MetricWindow sums_;  // means hold sums until the window closes
  std::vector<MetricWindow> windows_;
};

}  // namespace sweepstake::cli
