// Finds the pairs that a broad phase must find, by the definition in aabb.h alone, and describes
// how other pairs differ. Tests all pairs and shares no code with the faster oracle of
// `sweepstake-lab check`, so that neither can hide an error of the other.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sweepstake/aabb.h"

namespace sweepstake::test_support {

// Returns every overlapping pair in ascending order. Cost: n²/2 scalar tests.
std::vector<OverlapPair> ScalarPairs(std::span<const Aabb> boxes);

// Returns the pairs in ascending order, including duplicates.
std::vector<OverlapPair> Sorted(std::span<const OverlapPair> pairs);

// Returns an empty text if both contain the same pairs equally often. Otherwise returns one line
// with the first pairs that are missing, surplus, duplicate or not a < b. REQUIRES: `expected` is a
// result of ScalarPairs.
std::string PairDifference(std::span<const OverlapPair> found,
                           std::span<const OverlapPair> expected);

}  // namespace sweepstake::test_support
