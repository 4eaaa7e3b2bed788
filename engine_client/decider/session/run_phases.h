// The two phases of a run: the exploration, which runs every arm once in an order that the seed
// fixes (paper §6.3), and the observation window after it, over which active time and switches are
// counted (paper §6.2).
//
// Neither measures frames. Not thread-safe; the memory is bounded by the number of arms.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Returns a permutation of 0 … arm_count − 1 (Fisher–Yates shuffle), which is the same for the same
// seed on every platform.
std::vector<uint32_t> ExplorationOrder(uint64_t seed, uint32_t arm_count);

// The order of the exploration, and the arm whose turn it is.
class Exploration {
 public:
  // A slot is skipped if the client does not execute its command this many times: the client does
  // not have the arm.
  static constexpr uint32_t kMaxCommands = 3;

  // The first `explored` arms of the order are already done.
  Exploration(uint64_t seed, uint32_t arm_count, uint32_t explored);

  bool done() const { return explored_ == order_.size(); }
  uint32_t explored_arm_count() const { return explored_; }
  // The arm whose turn it is. REQUIRES: !done().
  uint32_t slot_arm() const { return order_[explored_]; }

  // REQUIRES: !done().
  void EndSlot();
  // Counts a command for the slot's arm. Returns false if kMaxCommands were given already.
  // REQUIRES: !done().
  bool CountCommand();

 private:
  std::vector<uint32_t> order_;
  uint32_t explored_;
  uint32_t command_count_ = 0;  // commands of the current slot
};

// Counts active time per arm and executed switches by reason. Active time is the caller's clock
// time between activations, with settling and stalls included.
class ObservationWindow {
 public:
  ObservationWindow(size_t arm_count, uint32_t active_arm);

  // Starts the window, when the exploration has ended. REQUIRES: not started.
  void Start(int64_t now_ns);
  // The arm is active from then on. Before the start only the arm is remembered.
  void Activate(uint32_t arm, SwitchReason reason, int64_t executed_ns);
  // Replaces the reason of the last activation.
  void CorrectReason(SwitchReason reason);

  // Returns the counts up to now, with the active arm's time until now.
  ObservationSummary Summary(int64_t now_ns) const;

 private:
  void Charge(ObservationSummary& summary, int64_t now_ns) const;

  ObservationSummary summary_;  // the run up to the last activation
  uint32_t active_arm_;
  int64_t active_since_ns_ = 0;
  SwitchReason last_reason_ = SwitchReason::kPolicy;
  bool last_counted_ = false;
};

}  // namespace sweepstake::decision
