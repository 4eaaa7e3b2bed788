// How a backend that the shadow lane has prepared comes to the frame thread: one atomic word that
// both sides change, so that neither waits.
//
//   frame: Want(arm) → wanted → lane: Offer → ready → frame: Take → taken → frame: Done → none
//                             → lane: Decline → declined
//
// While the word says wanted, or nothing, the lane's backend of the arm is the lane's; from Take to
// Done it is the frame thread's. A new Want or a Cancel makes every earlier order void: the lane's
// answer to it is lost.
//
// Thread safety: Want, Cancel, Take and Done on the frame thread, Offer and Decline on the lane's,
// order() on both. Lock-free.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake {

class SwitchHandover {
 public:
  enum class State : uint32_t { kNone, kWanted, kReady, kTaken, kDeclined };

  struct Order {
    State state = State::kNone;
    uint32_t arm = 0;
    uint32_t ticket = 0;  // one more with each Want and Cancel

    friend bool operator==(const Order&, const Order&) = default;
  };

  Order order() const { return Unpack(word_.load(std::memory_order_acquire)); }

  // REQUIRES: arm < 256.
  void Want(uint32_t arm) { Store({State::kWanted, arm, order().ticket + 1}); }
  void Cancel() { Store({State::kNone, 0, order().ticket + 1}); }
  // True where the order is ready: the lane's backend of its arm is the caller's until Done.
  bool Take() {
    const Order ready = order();
    return ready.state == State::kReady && Replace(ready, State::kTaken);
  }
  void Done() { Store({State::kNone, 0, order().ticket}); }

  // The answer to `wanted`; false where it is void.
  bool Offer(const Order& wanted) { return Replace(wanted, State::kReady); }
  bool Decline(const Order& wanted) { return Replace(wanted, State::kDeclined); }

 private:
  // ticket (32 bits) | arm (8) | state (8).
  static uint64_t Pack(const Order& order) {
    return uint64_t{order.ticket} << 32 | uint64_t{order.arm} << 8 |
           static_cast<uint32_t>(order.state);
  }
  static Order Unpack(uint64_t word) {
    return {static_cast<State>(word & 0xFF), static_cast<uint32_t>(word >> 8 & 0xFF),
            static_cast<uint32_t>(word >> 32)};
  }

  void Store(const Order& order) { word_.store(Pack(order), std::memory_order_release); }
  bool Replace(const Order& from, State state) {
    uint64_t expected = Pack(from);
    return word_.compare_exchange_strong(expected, Pack({state, from.arm, from.ticket}),
                                         std::memory_order_acq_rel);
  }

  std::atomic<uint64_t> word_{0};
};

}  // namespace sweepstake
