// Passes one operator order to the frame thread. A newer order overwrites one that was not taken
// yet. Any thread may call Post; only the frame thread calls Take. Lock-free.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "sweepstake/frame_sample.h"

namespace sweepstake {

class OrderMailbox {
 public:
  // Stores the order with the lowest 48 bits of its id. REQUIRES: arm < 255.
  void Post(const OperatorOrder& order) noexcept {
    slot_.store(order.order_id << 16 | uint64_t{order.arm.value_or(kNoArm)} << 8 |
                    static_cast<uint64_t>(order.mode),
                std::memory_order_release);
  }

  std::optional<OperatorOrder> Take() noexcept {
    // Test with a plain load first, because the slot is empty in nearly every frame and an exchange
    // is expensive.
    if (slot_.load(std::memory_order_relaxed) == 0) return std::nullopt;
    const uint64_t slot = slot_.exchange(0, std::memory_order_acquire);
    const auto arm = static_cast<uint32_t>(slot >> 8 & 0xff);
    return OperatorOrder{.order_id = slot >> 16,
                         .mode = static_cast<Mode>(slot & 0xff),
                         .arm = arm == kNoArm ? std::nullopt : std::optional(arm)};
  }

 private:
  static constexpr uint32_t kNoArm = 0xff;

  // Layout: order id (48 bits) | arm (8) | mode (8). The value 0 means empty; no mode has the value
  // 0.
  std::atomic<uint64_t> slot_{0};
};

}  // namespace sweepstake
