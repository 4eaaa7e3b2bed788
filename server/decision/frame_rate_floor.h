// Whether a scene is degraded: even the arm that is the best most probably misses the floor of the
// frame rate (paper §7.1).
//
// So that it does not flicker, it takes kWindowCount windows in a row to say so, and as many to
// take it back: windows of the leader under the floor, or windows of any arm at or above it. A
// window of another arm under the floor says nothing. At the paper's interval that is 6 s. Plain
// value; not thread-safe.
#pragma once

#include <cstdint>

namespace sweepstake::decision {

class FrameRateFloor {
 public:
  static constexpr uint32_t kWindowCount = 3;

  // 0: nothing is under it.
  explicit FrameRateFloor(double floor_fps) : floor_fps_(floor_fps) {}

  // A window of the active arm. A bail-out charged to it counts as one of 0 FPS: its frames are in
  // no window.
  void Observe(double fps, bool of_leader);
  bool degraded() const { return degraded_; }

 private:
  double floor_fps_;
  bool degraded_ = false;
  uint32_t contrary_count_ = 0;  // windows in a row that say otherwise
};

}  // namespace sweepstake::decision
