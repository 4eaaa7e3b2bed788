// The pairs that are right, found by a plain sorted sweep with the definition of overlap itself
// (aabb.h): no vector code, no structure kept, nothing shared with the backends it judges. Sorted,
// so that `sweepstake check` judges 3,000 objects over hundreds of frames in seconds; the tests
// judge this oracle, too, by one that compares every two boxes (tests/support/pair_oracle.h).
//
// Not thread-safe; keeps its memory, 8 bytes per pair. Cost: a sort plus one test per two boxes
// whose x intervals meet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sweepstake/aabb.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

class PairOracle {
 public:
  // All overlapping pairs, sorted; valid until the next call.
  std::span<const OverlapPair> Find(std::span<const Aabb> boxes);
  // The same, or kResourceExhausted when there are more than `most_pairs`, found out without
  // holding more.
  Result<std::span<const OverlapPair>> FindUpTo(size_t most_pairs, std::span<const Aabb> boxes);

 private:
  // False: there are more.
  bool Sweep(size_t most_pairs, std::span<const Aabb> boxes);

  std::vector<uint32_t> order_;
  std::vector<OverlapPair> pairs_;
};

// Where found pairs differ from the right ones. Each list is sorted.
struct PairDifference {
  std::vector<OverlapPair> missing;
  std::vector<OverlapPair> extra;  // wrong ones, repeated ones, and those with a >= b

  bool empty() const { return missing.empty() && extra.empty(); }
};

// Compares by identity. `found` is in any order and is sorted in place; `right` is sorted.
PairDifference ComparePairs(std::span<OverlapPair> found, std::span<const OverlapPair> right);

}  // namespace sweepstake::cli
