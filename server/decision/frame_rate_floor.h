// Whether a scene is degraded: even the arm that is the best most probably misses the floor of the
// frame rate (paper §7.1).
//
// So that it does not flicker, it takes kWindowCount windows in a row to say so, and as many to
// take it back: windows under the floor, whatever the arm, while the leader's own latest one was
// under it too; or windows at or above it. A slow window says nothing where the leader was fast
// when it ran, or never ran. At the paper's interval three windows are 6 s. Not thread-safe.
#pragma once

#include <cstdint>
#include <vector>

namespace sweepstake::decision {

class FrameRateFloor {
 public:
  static constexpr uint32_t kWindowCount = 3;

  // A floor of 0: nothing is under it.
  FrameRateFloor(double floor_fps, uint32_t arm_count)
      : floor_fps_(floor_fps), missed_(arm_count) {}

  // A window of `arm`. A bail-out charged to it counts as one of 0 FPS: its frames are in no
  // window. REQUIRES: arm, leader < arm_count.
  void Observe(uint32_t arm, double fps, uint32_t leader);
  bool degraded() const { return degraded_; }

 private:
  double floor_fps_;
  std::vector<bool> missed_;  // per arm, whether its latest window was under the floor
  bool degraded_ = false;
  uint32_t contrary_count_ = 0;  // windows in a row that say otherwise
};

}  // namespace sweepstake::decision
