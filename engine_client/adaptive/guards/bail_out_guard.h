// Finds frames over the bail-out limit (paper §4). If a decider is present, it judges these frames
// by its policy. If none is present, this guard chooses the arm to switch to.
//
// The setters may be called on any thread, the other functions on the frame thread. No function
// waits. Posterior means are read one by one. A choice made while a new snapshot is being written
// may therefore mix two snapshots, and choose the second-best arm.
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

  // Sets the limit. 0 is ignored.
  void SetLimit(uint64_t limit_ns);
  void SetDeciderPresent(bool present);
  // Stores the posterior mean of each arm. Ignores a list that does not have one finite mean per
  // arm.
  void SetPosteriorMeans(std::span<const double> means);

  bool Exceeds(uint64_t frame_time_ns) const {
    return frame_time_ns > limit_ns_.load(std::memory_order_relaxed);
  }

  // Returns whether the frame exceeds the limit because of its arm (IsCausedByDetection).
  bool IsCausedByArm(const FrameSample& sample) const;

  // Returns the arm to switch to after this frame. Absent if the frame does not exceed the limit
  // because of its arm, if a decider is present, or if there is no other arm.
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
