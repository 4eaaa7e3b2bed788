// The pairs a broad phase must find, by the definition of aabb.h alone, and a readable comparison.
// It leaves no pair out by any reasoning, and shares no code with the faster oracle of `sweepstake
// check`, so that neither can hide a fault of the other.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sweepstake/aabb.h"

namespace sweepstake::test_support {

// Returns every overlapping pair in ascending order. Cost: n²/2 scalar tests.
std::vector<OverlapPair> ScalarPairs(std::span<const Aabb> boxes);

// Ascending order, duplicates kept.
std::vector<OverlapPair> Sorted(std::span<const OverlapPair> pairs);

// Empty when both hold the same pairs as often; else one line with the first few that are missing,
// surplus, doubled or not a < b. REQUIRES: `expected` as ScalarPairs returns it.
std::string PairDifference(std::span<const OverlapPair> found,
                           std::span<const OverlapPair> expected);

}  // namespace sweepstake::test_support
