// Passes a backend that the shadow lane has prepared to the frame thread. Both sides change one
// atomic word, so that neither waits.
//
//   frame: Want(arm) → wanted → lane: Offer → ready → frame: Take → taken → frame: Done → none
//                             → lane: Decline → declined
//
// The lane's backend of the arm belongs to the frame thread from Take to Done, otherwise to the
// lane. A new Want or a Cancel voids every earlier order: a later Offer or Decline for it has no
// effect.
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
    uint32_t ticket = 0;  // incremented by each Want and Cancel

    friend bool operator==(const Order&, const Order&) = default;
  };

  Order order() const { return Unpack(word_.load(std::memory_order_acquire)); }

  // REQUIRES: arm < 256.
  void Want(uint32_t arm) { Store({State::kWanted, arm, order().ticket + 1}); }
  void Cancel() { Store({State::kNone, 0, order().ticket + 1}); }
  // Returns true if the order is ready; the lane's backend of its arm then belongs to the caller
  // until Done. Cancels an order that is not ready yet, because nobody would take the backend
  // later.
  bool Take() {
    const Order ready = order();
    if (ready.state == State::kReady && Replace(ready, State::kTaken)) return true;
    if (ready.state != State::kTaken) Cancel();
    return false;
  }
  void Done() { Store({State::kNone, 0, order().ticket}); }

  // Answers the order `wanted`; returns false if it is void.
  bool Offer(const Order& wanted) { return Replace(wanted, State::kReady); }
  bool Decline(const Order& wanted) { return Replace(wanted, State::kDeclined); }

 private:
  // Layout: ticket (32 bits) | arm (8) | state (8).
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
