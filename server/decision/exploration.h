// The initial exploration: every arm once, in an order that the seed fixes (paper §6.3).
//
// Says which arm's turn it is; measures nothing. Not thread-safe.
#pragma once

#include <cstdint>
#include <vector>

namespace sweepstake::decision {

// A permutation of 0 … arm_count − 1 (Fisher and Yates' shuffle), the same for the same seed
// everywhere.
std::vector<uint32_t> ExplorationOrder(uint64_t seed, uint32_t arm_count);

class Exploration {
 public:
  // A client that does not execute a slot's command this many times does not have the arm; the slot
  // is passed over.
  static constexpr uint32_t kMaxCommands = 3;

  // `explored` arms of the order are done already.
  Exploration(uint64_t seed, uint32_t arm_count, uint32_t explored);

  bool done() const { return explored_ == order_.size(); }
  uint32_t explored_arm_count() const { return explored_; }
  // The arm whose turn it is. REQUIRES: !done().
  uint32_t slot_arm() const { return order_[explored_]; }

  // REQUIRES: !done().
  void EndSlot();
  // Counts a command for the slot's arm; false: it had all its commands. REQUIRES: !done().
  bool CountCommand();

 private:
  std::vector<uint32_t> order_;
  uint32_t explored_;
  uint32_t command_count_ = 0;  // of this slot
};

}  // namespace sweepstake::decision
