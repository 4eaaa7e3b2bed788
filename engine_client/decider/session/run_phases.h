// The two phases of a run. In the exploration every arm runs once, in an order that the seed
// determines (paper §6.3). In the observation window after it, active time and switches are counted
// (paper §6.2).
//
// These classes do not measure frames. Not thread-safe; the memory is bounded by the number of
// arms.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Returns a permutation of 0 … arm_count − 1 (Fisher–Yates shuffle), which is the same for the same
// seed on every platform.
std::vector<uint32_t> ExplorationOrder(uint64_t seed, uint32_t arm_count);

// The order in which the exploration runs the arms, and the arm that is explored now.
class Exploration {
 public:
  // The slot of an arm is skipped after this many commands that the client did not execute. The
  // client probably does not have the arm.
  static constexpr uint32_t kMaxCommands = 3;

  // `explored` is the number of arms, from the start of the order, that were explored before a
  // restart.
  Exploration(uint64_t seed, uint32_t arm_count, uint32_t explored);

  bool done() const { return explored_ == order_.size(); }
  uint32_t explored_arm_count() const { return explored_; }
  // Returns the arm that is explored now. REQUIRES: !done().
  uint32_t slot_arm() const { return order_[explored_]; }

  // REQUIRES: !done().
  void EndSlot();
  // Counts a command for the slot's arm. Returns false if kMaxCommands were already issued.
  // REQUIRES: !done().
  bool CountCommand();

 private:
  std::vector<uint32_t> order_;
  uint32_t explored_;
  uint32_t command_count_ = 0;  // commands of the current slot
};

// Counts active time per arm and executed switches by reason. Active time is the time between
// activations on the caller's clock; it includes settling and stalls.
class ObservationWindow {
 public:
  ObservationWindow(size_t arm_count, uint32_t active_arm);

  // Starts the window; called at the end of the exploration. REQUIRES: not started.
  void Start(int64_t now_ns);
  // Makes the arm active from executed_ns on. Before Start, only the arm is stored and nothing is
  // counted.
  void Activate(uint32_t arm, SwitchReason reason, int64_t executed_ns);
  // Replaces the reason of the last activation.
  void CorrectReason(SwitchReason reason);

  // Returns the counts up to now_ns, including the current arm's active time.
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
