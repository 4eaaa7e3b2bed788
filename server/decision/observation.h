// Keeps the books of the observation window: active time per arm and executed switches by reason
// (paper §6.2).
//
// Active time is the time of the caller's clock between activations, settling and stalls included.
// The window starts when the exploration has ended. Not thread-safe; memory is bounded by the
// number of arms.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/decision/types.h"

namespace sweepstake::decision {

class Observation {
 public:
  Observation(size_t arm_count, uint32_t active_arm);

  // REQUIRES: not started.
  void Start(int64_t now_ns);
  // The arm is active from then on. Before the start only the arm is remembered.
  void Activate(uint32_t arm, SwitchReason reason, int64_t executed_ns);
  // The last activation turns out to have had this reason.
  void CorrectReason(SwitchReason reason);

  // As of now: the active arm's time runs until then.
  ObservationSummary Summary(int64_t now_ns) const;

 private:
  void Charge(ObservationSummary& summary, int64_t now_ns) const;

  ObservationSummary summary_;  // up to the last activation
  uint32_t active_arm_;
  int64_t active_since_ns_ = 0;
  SwitchReason last_reason_ = SwitchReason::kPolicy;
  bool last_counted_ = false;
};

}  // namespace sweepstake::decision
