#include "engine_client/cli/experiment/metric_window_meter.h"

#include <algorithm>
#include <utility>

namespace sweepstake::cli {

void MetricWindowMeter::Add(const FrameSample& sample, uint64_t now_ns) {
  if (sums_.frame_count > 0 && (sample.arm != sums_.arm || now_ns - begin_ns_ >= interval_ns_)) {
    Close(now_ns);
  }
  const double frame_us = static_cast<double>(sample.frame_time_ns) * 1e-3;
  ++sums_.frame_count;
  sums_.arm = sample.arm;
  sums_.object_count = sample.object_count;
  sums_.frame_us_mean += frame_us;
  sums_.frame_us_max = std::max(sums_.frame_us_max, frame_us);
  sums_.detection_us_mean += static_cast<double>(sample.detection_time_ns) * 1e-3;
  sums_.check_count_mean += static_cast<double>(sample.aabb_check_count);
  sums_.pair_count_mean += static_cast<double>(sample.pair_count);
  sums_.native_bytes_max = std::max(sums_.native_bytes_max, sample.native_bytes);
}

std::vector<MetricWindow> MetricWindowMeter::Take(uint64_t now_ns) {
  if (sums_.frame_count > 0) Close(now_ns);
  return std::exchange(windows_, {});
}

void MetricWindowMeter::Close(uint64_t now_ns) {
  const double count = static_cast<double>(sums_.frame_count);
  sums_.time_s = static_cast<double>(now_ns) * 1e-9;
  sums_.frame_us_mean /= count;
  sums_.detection_us_mean /= count;
  sums_.check_count_mean /= count;
  sums_.pair_count_mean /= count;
  windows_.push_back(sums_);
  sums_ = {};
  begin_ns_ = now_ns;
}

}  // namespace sweepstake::cli
