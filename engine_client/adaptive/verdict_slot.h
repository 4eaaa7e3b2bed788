// Passes the latest verdict from the thread that receives it to any other thread. Lock-free. The
// whole verdict is one atomic word, so a reader never sees parts of two verdicts.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "sweepstake/frame_sample.h"

namespace sweepstake {

class VerdictSlot {
 public:
  // REQUIRES: leader_arm < 2^24.
  void Set(const SceneVerdict& verdict) noexcept {
    const auto probability =
        std::bit_cast<uint32_t>(static_cast<float>(verdict.leader_probability));
    slot_.store(uint64_t{probability} << 32 | uint64_t{verdict.leader_arm} << 8 |
                    static_cast<uint64_t>(verdict.verdict),
                std::memory_order_relaxed);
  }

  SceneVerdict Get() const noexcept {
    const uint64_t slot = slot_.load(std::memory_order_relaxed);
    return {.verdict = static_cast<Verdict>(slot & 0xff),
            .leader_arm = static_cast<uint32_t>(slot >> 8 & 0xff'ffff),
            .leader_probability = std::bit_cast<float>(static_cast<uint32_t>(slot >> 32))};
  }

 private:
  // Layout: probability as a float (32 bits) | arm (24) | verdict (8).
  std::atomic<uint64_t> slot_{0};
};

}  // namespace sweepstake
