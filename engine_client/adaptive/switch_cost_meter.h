// Measures the cost of a switch of arms: the build time of the new backend's structure, and the
// frame time lost until the new arm has settled.
//
// The settled mean is the mean frame time of the second half of the settling time. The settling
// cost is the sum of what the frames of the first half took above that mean, at least 0. Paused and
// loading frames count for neither. A switch before the last one has settled ends that measurement
// early.
//
// SetSettling may be called from any thread, the rest on the frame thread. Nothing waits or
// allocates.
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

  // Begins the measurement of a switch; `warm` says that the structure exists already. Returns the
  // outcome of the previous switch if that one has not settled.
  std::optional<SwitchOutcome> Begin(const SwitchCommand& command, uint32_t switch_epoch,
                                     bool warm = false);

  // Returns true from the Begin of a cold switch to OnRebuild: the next build belongs to the
  // switch.
  bool awaits_rebuild() const { return awaits_rebuild_; }
  void OnRebuild(uint64_t rebuild_time_ns);

  // Adds a finished frame. Returns the outcome at the frame that settles the arm.
  std::optional<SwitchOutcome> OnFrame(const FrameSample& sample);

 private:
  // Frames of one half of the settling time.
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
