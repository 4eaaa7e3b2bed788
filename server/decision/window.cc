#include "server/decision/window.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sweepstake::decision {

bool WindowMetrics::IsFinite() const {
  return std::isfinite(fps) && std::isfinite(detection_ms) && std::isfinite(native_mib) &&
         std::isfinite(check_ratio);
}

void Window::Add(const Frame& frame) {
  ++frame_count_;
  time_ns_ += static_cast<double>(frame.frame_time_ns);
  const double detection_ns = static_cast<double>(frame.detection_time_ns);
  if ((frame.flags & kFrameRebuild) != 0) {
    rebuild_detection_ns_ += detection_ns;
  } else {
    ++ordinary_frame_count_;
    ordinary_detection_ns_ += detection_ns;
  }
  const double n = frame.object_count;
  check_count_ += static_cast<double>(frame.aabb_check_count);
  pair_count_ += n > 0 ? n * (n - 1) * 0.5 : 0;
  peak_bytes_ = std::max(peak_bytes_, frame.native_bytes);
}

WindowMetrics Window::Metrics() const {
  assert(!empty());
  const double frames = static_cast<double>(frame_count_);
  WindowMetrics metrics;
  metrics.fps = frames / time_ns_ * 1e9;
  const double detection_ns =
      ordinary_frame_count_ > 0
          ? ordinary_detection_ns_ / static_cast<double>(ordinary_frame_count_)
          : rebuild_detection_ns_ / frames;
  metrics.detection_ms = detection_ns * 1e-6;
  metrics.native_mib = static_cast<double>(peak_bytes_) / (1024.0 * 1024.0);
  metrics.check_ratio =
      pair_count_ > 0 ? check_count_ / pair_count_ : (check_count_ > 0 ? 1.0 : 0.0);
  return metrics;
}

}  // namespace sweepstake::decision
