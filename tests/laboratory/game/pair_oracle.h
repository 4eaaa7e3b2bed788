// Finds the right pairs with a plain sorted sweep and the definition of overlap itself (aabb.h). It
// has no vector code, keeps no structure between frames, and shares nothing with the backends that
// are compared with it. The sort makes `sweepstake-lab check` take seconds for 3,000 objects over
// hundreds of frames. The tests compare this oracle with one that tests every two boxes
// (tests/support/pair_oracle.h).
//
// Not thread-safe. Keeps its memory, 8 bytes per pair. Cost: a sort plus one test per two boxes
// whose x intervals overlap.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sweepstake/aabb.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

class PairOracle {
 public:
  // Returns all overlap pairs, sorted. The span is valid until the next call.
  std::span<const OverlapPair> Find(std::span<const Aabb> boxes);
  // Returns all overlap pairs as Find does. Error: kResourceExhausted (there are more than
  // `max_pairs`; the search stops there).
  Result<std::span<const OverlapPair>> FindUpTo(size_t max_pairs, std::span<const Aabb> boxes);

 private:
  // Returns false if there are more than `max_pairs`.
  bool Sweep(size_t max_pairs, std::span<const Aabb> boxes);

  std::vector<uint32_t> order_;
  std::vector<OverlapPair> pairs_;
};

// The differences between the found pairs and the right ones. Each list is sorted.
struct PairDifference {
  std::vector<OverlapPair> missing;
  // Wrong pairs, repeated pairs, and pairs with a >= b.
  std::vector<OverlapPair> extra;

  bool empty() const { return missing.empty() && extra.empty(); }
};

// Compares by identity. `found` may have any order and is sorted in place. REQUIRES: `right` is
// sorted.
PairDifference ComparePairs(std::span<OverlapPair> found, std::span<const OverlapPair> right);

// A fingerprint of a set of pairs for tests of equality. The same pairs in any order have the same
// fingerprint, and different pairs almost certainly have different ones (two 64-bit sums of
// hashes). It costs about as much as reading the pairs, far less than sorting them, so every frame
// of every backend can be compared.
struct PairFingerprint {
  uint64_t count = 0;
  uint64_t sums[2] = {0, 0};

  friend bool operator==(const PairFingerprint&, const PairFingerprint&) = default;
};

// Returns the fingerprint. A pair that is found twice counts twice; a pair with its ids swapped is
// a different pair. A pure function.
PairFingerprint FingerprintOf(std::span<const OverlapPair> pairs);

}  // namespace sweepstake::cli
