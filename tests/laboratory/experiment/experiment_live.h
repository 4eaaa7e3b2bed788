// Plays one live run of an experiment: a real GameRun with the embedded decider, which starts from
// Beta(1,1) and goes through the exploration and the observation window. Then every arm runs alone
// on the same scene as a control.
//
// The calling thread is the frame thread; the session has its own sender thread. Frames are not
// paced.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_plan.h"
#include "tests/laboratory/experiment/experiment_record.h"

namespace sweepstake::cli {

struct LiveOptions {
  uint64_t window_ns = 0;  // in real time
  double time_scale = 1;
  std::filesystem::path frames_file;  // CSV file for every frame's metrics; empty: none
  // Called between frames with the real time since the run began. The run stops if it returns
  // false.
  std::function<bool(uint64_t elapsed_ns)> go_on;
};

// Returns the record, or nothing if go_on returned false. Errors: those of OpenScene,
// MakeStudySession and CsvFile, and kInternal (the exploration takes ten times as long as
// planned).
Result<std::optional<RunRecord>> PlayLive(const PlannedRun& planned, const LiveOptions& options);

// Summarizes frames as windows: the means and extremes of the frames that ran on one arm within an
// interval. There is one window per interval and per change of arm. Not thread-safe.
class MetricWindowMeter {
 public:
  // REQUIRES: interval_ns > 0.
  explicit MetricWindowMeter(uint64_t interval_ns) : interval_ns_(interval_ns) {}

  // `now_ns` is the time from the run's start to the frame's end.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // Returns the windows, including the current one.
  std::vector<MetricWindow> Take(uint64_t now_ns);

 private:
  void Close(uint64_t now_ns);

  const uint64_t interval_ns_;
  uint64_t begin_ns_ = 0;
  MetricWindow sums_;  // the means are sums until the window is closed
  std::vector<MetricWindow> windows_;
};

}  // namespace sweepstake::cli
