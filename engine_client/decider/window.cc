#include "engine_client/decider/window.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sweepstake::decision {
namespace {

constexpr double kTypicalStep = 1.02;  // relative step of the typical time per frame
// A frame is long above this multiple of the typical time. Its excess does not count.
constexpr double kMaxCalmRatio = 2;
// If at most one in kFramesPerInterruption frames is long, the long frames count as interruptions
// of the frame thread. More long frames are the arm's own cost.
constexpr uint64_t kFramesPerInterruption = 5;

}  // namespace

bool WindowMetrics::IsFinite() const {
  return std::isfinite(fps) && std::isfinite(detection_ms) && std::isfinite(calm_detection_ms) &&
         std::isfinite(native_mib) && std::isfinite(check_ratio);
}

void Window::Add(const FrameSample& frame) {
  ++frame_count_;
  time_ns_ += static_cast<double>(frame.frame_time_ns);
  const double detection_ns = static_cast<double>(frame.detection_time_ns);
  if ((frame.flags & kFrameRebuild) != 0) {
    rebuild_detection_ns_ += detection_ns;
  } else {
    ++ordinary_frame_count_;
    ordinary_detection_ns_ += detection_ns;
    AddCalm(detection_ns);
  }
  const double n = frame.object_count;
  check_count_ += static_cast<double>(frame.aabb_check_count);
  pair_count_ += n > 0 ? n * (n - 1) * 0.5 : 0;
  peak_bytes_ = std::max(peak_bytes_, frame.native_bytes);
}

// Adds a frame to the calm frames. The typical time approximates the median by stochastic
// approximation: each frame moves it up or down by the factor kTypicalStep.
void Window::AddCalm(double detection_ns) {
  if (detection_ns == 0) return;
  ++calm_frame_count_;
  double& typical_ns = typical_detection_ns_;
  if (typical_ns == 0) typical_ns = detection_ns;
  if (detection_ns > kMaxCalmRatio * typical_ns) ++long_frame_count_;
  calm_detection_ns_ += std::min(detection_ns, kMaxCalmRatio * typical_ns);
  typical_ns = detection_ns > typical_ns ? typical_ns * kTypicalStep : typical_ns / kTypicalStep;
}

void Window::Add(const Window& later) {
  frame_count_ += later.frame_count_;
  ordinary_frame_count_ += later.ordinary_frame_count_;
  time_ns_ += later.time_ns_;
  ordinary_detection_ns_ += later.ordinary_detection_ns_;
  calm_detection_ns_ += later.calm_detection_ns_;
  calm_frame_count_ += later.calm_frame_count_;
  long_frame_count_ += later.long_frame_count_;
  typical_detection_ns_ = later.typical_detection_ns_;
  rebuild_detection_ns_ += later.rebuild_detection_ns_;
  check_count_ += later.check_count_;
  pair_count_ += later.pair_count_;
  peak_bytes_ = std::max(peak_bytes_, later.peak_bytes_);
}

void Window::Clear() {
  const double typical_ns = typical_detection_ns_;
  *this = Window();
  typical_detection_ns_ = typical_ns;
}

WindowMetrics Window::Metrics() const {
  assert(!empty());
  const double frames = static_cast<double>(frame_count_);
  WindowMetrics metrics;
  metrics.fps = frames / time_ns_ * 1e9;
  const bool rebuilds_only = ordinary_frame_count_ == 0;
  const double rebuild_ms = rebuild_detection_ns_ / frames * 1e-6;
  metrics.detection_ms =
      rebuilds_only ? rebuild_ms
                    : ordinary_detection_ns_ / static_cast<double>(ordinary_frame_count_) * 1e-6;
  const bool stays_long = long_frame_count_ * kFramesPerInterruption > calm_frame_count_;
  const double calm_ns = stays_long ? ordinary_detection_ns_ : calm_detection_ns_;
  metrics.calm_detection_ms =
      calm_frame_count_ == 0 ? rebuild_ms : calm_ns / static_cast<double>(calm_frame_count_) * 1e-6;
  metrics.native_mib = static_cast<double>(peak_bytes_) / (1024.0 * 1024.0);
  metrics.check_ratio =
      pair_count_ > 0 ? check_count_ / pair_count_ : (check_count_ > 0 ? 1.0 : 0.0);
  return metrics;
}

}  // namespace sweepstake::decision
