// The update rule of the posterior (paper §4): a window with reward r changes the Beta posterior of
// the active arm, and of no other, to α ← α + r, β ← β + (1 − r). A bail-out adds observations of
// reward 0.
//
// A change is an Increment first, so that what is stored and what the session believes are the same
// numbers. Rewards of version 3 weigh each window by its own noise (LogCostIncrement in
// log_cost.h). Pure functions.
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
