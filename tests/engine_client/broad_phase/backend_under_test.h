// Creates a backend by name and checks the pairs that it finds.
#pragma once

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

}  // namespace sweepstake::test_support
