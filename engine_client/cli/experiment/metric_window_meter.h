// Thins frames to windows: means and extremes of the frames that ran on one arm within an interval.
// Not thread-safe. Appends one window per interval and change of arm.
#pragma once

#include <cstdint>
#include <vector>

#include "engine_client/cli/experiment/experiment_record.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake::cli {

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
