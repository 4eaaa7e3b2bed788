// Passes a backend that the shadow lane has prepared to the frame thread. Both threads change one
// atomic word, so neither waits for the other.
//
//   frame: Want(arm) → wanted → lane: Offer → ready → frame: Take → taken → frame: Done → none
//                             → lane: Decline → declined
//
// From Take to Done, the lane's backend of the arm belongs to the frame thread; at all other times
// it belongs to the lane. A new Want or a Cancel makes every earlier order void. If the lane then
// offers or declines an earlier order, nothing happens.
//
// Thread safety: Want, Cancel, Take and Done on the frame thread, Offer and Decline on the lane's
// thread, order() on both. Lock-free.
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
    uint32_t ticket = 0;  // each Want and Cancel increments it

    friend bool operator==(const Order&, const Order&) = default;
  };

  Order order() const { return Unpack(word_.load(std::memory_order_acquire)); }

  // Orders a preparation of `arm`. REQUIRES: arm < 256.
  void Want(uint32_t arm) { Store({State::kWanted, arm, order().ticket + 1}); }
  void Cancel() { Store({State::kNone, 0, order().ticket + 1}); }
  // If the order is ready, returns true; the lane's backend of the arm then belongs to the caller
  // until Done. If the order is not ready yet, cancels it and returns false, because the switch
  // happens without the lane and the prepared backend would never be used.
  bool Take() {
    const Order ready = order();
    if (ready.state == State::kReady && Replace(ready, State::kTaken)) return true;
    if (ready.state != State::kTaken) Cancel();
    return false;
  }
  void Done() { Store({State::kNone, 0, order().ticket}); }

  // Answer the order `wanted`. Return false if that order is void.
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
