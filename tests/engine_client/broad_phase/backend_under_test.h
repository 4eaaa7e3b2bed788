// Creates a backend by name and checks the pairs that it finds.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sweepstake/broad_phase.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake::test_support {

inline std::unique_ptr<BroadPhase> MakeOrThrow(std::string_view name) {
  auto made = MakeBroadPhase(name);
  if (!made.ok()) throw std::runtime_error(made.status().message());
  return std::move(*made);
}

// Replaces `pairs` by the backend's current pairs and describes their errors; the result is empty
// if there are none.
inline std::string FindPairsError(BroadPhase& backend, std::span<const Aabb> boxes,
                                  PairBuffer& pairs) {
  pairs.Clear();
  backend.FindPairs(pairs);
  return PairDifference(pairs.pairs(), ScalarPairs(boxes));
}

// Searches with both backends and replaces `pairs` by the pairs of `backend`. The result is empty
// if both found the same sequence of pairs with the same number of AABB checks.
inline std::string SequenceError(BroadPhase& backend, BroadPhase& twin, PairBuffer& pairs) {
  PairBuffer twin_pairs;
  pairs.Clear();
  backend.FindPairs(pairs);
  twin.FindPairs(twin_pairs);
  if (!std::ranges::equal(pairs.pairs(), twin_pairs.pairs()))
    return "other pairs, or another order";
  return backend.aabb_check_count() == twin.aabb_check_count() ? "" : "another number of checks";
}

}  // namespace sweepstake::test_support
