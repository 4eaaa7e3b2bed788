// Step 5 of the one path: finds frames over the bail-out limit (paper §4), which the decider judges
// by its policy's rule, and, while no decider is present, chooses the arm to switch to.
//
// The setters may be called from any thread, the rest on the frame thread; nothing waits. Posterior
// means are read one by one: a choice that is made while a new snapshot is written may mix the two
// and take the second-best arm.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "sweepstake/frame_sample.h"

namespace sweepstake {

class BailOutGuard {
 public:
  static constexpr uint32_t kMaxArms = 32;

  // REQUIRES: limit_ns > 0, 1 <= arm_count <= kMaxArms.
  BailOutGuard(uint64_t limit_ns, uint32_t arm_count);

  // 0 is ignored.
  void SetLimit(uint64_t limit_ns);
  void SetDeciderPresent(bool present);
  // Ignores a snapshot that does not have one finite mean per arm.
  void SetPosteriorMeans(std::span<const double> means);

  bool Exceeds(uint64_t frame_time_ns) const {
    return frame_time_ns > limit_ns_.load(std::memory_order_relaxed);
  }

  // Returns whether the frame is over the limit because of its arm. It is not if detection took
  // less than half of it, or if the game was paused or loading.
  bool BlamesArm(const FrameSample& sample) const;

  // Returns the arm to switch to after this frame. It is absent if its arm is not to blame, if a
  // decider is present, or if there is no other arm.
  std::optional<uint32_t> LocalChoice(const FrameSample& sample) const;

 private:
  uint32_t BestOther(uint32_t active) const;

  std::atomic<uint64_t> limit_ns_;
  const uint32_t arm_count_;
  std::atomic<bool> decider_present_{false};
  std::atomic<bool> has_means_{false};
  std::array<std::atomic<double>, kMaxArms> means_{};
};

}  // namespace sweepstake
