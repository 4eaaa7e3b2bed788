// What policies that choose in the same manner share. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "server/decision/policy/policy.h"

namespace sweepstake::decision {

// The arm with the highest number; of equal ones the first. REQUIRES: there is one; none is NaN.
Choice HighestOf(std::vector<double> draws);

// That arm, without any draw.
Choice ChoiceOf(uint32_t arm);

// For policies that choose once in a cooldown, where the paper draws anew every Δt until a draw
// leaves the arm: at the first tick after each whole cooldown since the last switch. Until the
// first switch they count from the session's start, which is such a moment too, since there is
// nothing to wait for. A bail-out always is one. Whether the session holds the choice back
// (settling, no frames) does not matter: the next moment is a cooldown later.
bool IsTimeToChoose(const ChoiceInput& input, int64_t cooldown_ns);

}  // namespace sweepstake::decision
