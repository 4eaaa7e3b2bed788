// The paper's update rule of the posterior (§4). A window with reward r changes only the Beta
// posterior of the active arm: α ← α + r, β ← β + (1 − r). A bail-out adds observations of reward
// 0.
//
// Each change is first computed as an Increment. The same Increment is stored and applied to the
// session's posterior, so both have the same numbers. Reward version 3 has another rule, which
// weighs each window by its noise (LogCostIncrement in log_cost.h). Pure functions.
#pragma once

#include <cassert>
#include <cstdint>
#include <span>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Returns the increment of one window with this reward. REQUIRES: 0 <= reward <= 1.
inline Increment WindowIncrement(uint32_t arm, double reward) {
  assert(reward >= 0 && reward <= 1);
  return {.arm = arm, .alpha = reward, .beta = 1 - reward, .window_count = 1};
}

// Returns the increment of a bail-out: `penalty` observations of reward 0. REQUIRES: finite, >= 0.
inline Increment BailOutIncrement(uint32_t arm, double penalty) {
  assert(penalty >= 0);
  return {.arm = arm, .beta = penalty, .bail_out_count = 1};
}

// Adds the increment to its arm's posterior. REQUIRES: increment.arm < posteriors.size().
inline void Apply(const Increment& increment, std::span<BetaPosterior> posteriors) {
  assert(increment.arm < posteriors.size());
  posteriors[increment.arm].alpha += increment.alpha;
  posteriors[increment.arm].beta += increment.beta;
}

}  // namespace sweepstake::decision
