// The update rule of the posterior (paper §4): α ← α + r, β ← β + (1 − r), for the active arm only.
// Pure functions.
//
// A change is an Increment first, so that what is stored and what the session believes are the same
// numbers.
#pragma once

#include <cstdint>
#include <span>

#include "server/decision/types.h"

namespace sweepstake::decision {

// One window with this reward. REQUIRES: 0 <= reward <= 1.
Increment WindowIncrement(uint32_t arm, double reward);

// `penalty` observations of reward 0. REQUIRES: finite and >= 0.
Increment BailOutIncrement(uint32_t arm, double penalty);

// Adds the increment to its arm's posterior. REQUIRES: increment.arm < posteriors.size().
void Apply(const Increment& increment, std::span<BetaPosterior> posteriors);

}  // namespace sweepstake::decision
