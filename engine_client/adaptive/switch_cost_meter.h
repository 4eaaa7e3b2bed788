// Measures the cost of a switch: the time to build the new arm's structure, and the frame time lost
// until the new arm has settled.
//
// The settled mean is the mean frame time in the second half of the settling time. The settling
// cost is the sum, over the frames of the first half, of frame time minus settled mean, but at
// least 0. Frames with a flag of kFrameWithoutCost count in neither half. The build of a suspended
// frame counts as 0. If another switch comes before the end of the settling time, the measurement
// ends early.
//
// SetSettling may be called on any thread, the other functions on the frame thread. No function
// waits or allocates.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "sweepstake/frame_sample.h"

namespace sweepstake {

class SwitchCostMeter {
 public:
  explicit SwitchCostMeter(uint64_t settling_ns) : settling_ns_(settling_ns) {}

  void SetSettling(uint64_t settling_ns) {
    settling_ns_.store(settling_ns, std::memory_order_relaxed);
  }
  uint64_t settling_ns() const { return settling_ns_.load(std::memory_order_relaxed); }

  // Begins to measure a switch. `warm`: the structure is already built. If the settling time of the
  // previous switch had not ended, returns the outcome of that switch.
  std::optional<SwitchOutcome> Begin(const SwitchCommand& command, uint32_t switch_epoch,
                                     bool warm = false);

  // Returns true from the Begin of a cold switch until OnRebuild. During that time, a build belongs
  // to the cost of the switch.
  bool awaits_rebuild() const { return awaits_rebuild_; }
  void OnRebuild(uint64_t rebuild_time_ns);

  // Adds a finished frame. If the settling time ends with it, returns the outcome of the switch.
  std::optional<SwitchOutcome> OnFrame(const FrameSample& sample);

 private:
  // Sums over the frames of one half of the settling time.
  struct Half {
    uint64_t time_ns = 0;
    uint64_t frame_count = 0;
  };

  SwitchOutcome Finish();
  uint64_t SettlingCostNs() const;

  std::atomic<uint64_t> settling_ns_;
  std::optional<SwitchOutcome> running_;
  bool awaits_rebuild_ = false;
  Half early_;
  Half late_;
};

}  // namespace sweepstake
