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
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
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

// Compares two lists of pairs by the identity of the pairs. `found` may have any order and is
// sorted in place. REQUIRES: `right` is sorted.
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

// Compares backends with the oracle in every frame of a scene, by the identity of the pairs. A
// frame costs the oracle plus, for each backend, its search and a sort of its pairs.

struct FirstDifference {
  uint64_t frame = 0;
  PairDifference pairs;
};

struct ArmCheck {
  std::string arm;
  uint64_t frame_count = 0;  // frames before the first difference
  uint64_t pair_count = 0;   // the pairs of these frames, summed
  // Absent if the arm passed.
  std::optional<FirstDifference> first_difference;
};

// The maximum number of pairs of a frame. The oracle and every arm take 8 bytes per pair, and up to
// 24 while their buffers grow: 2 to 4 GB for all arms together.
inline constexpr size_t kMaxCheckedPairs = 20'000'000;

// Checks the scene's current frame and the next `step_count` frames. An arm whose pairs were wrong
// is not checked in later frames. `on_frame` is called with the number of frames done. Error:
// kResourceExhausted (a frame has more than `max_pairs` pairs; the arms are not run on that frame).
Result<std::vector<ArmCheck>> CheckScene(Scene& scene,
                                         std::span<const std::unique_ptr<BroadPhase>> arms,
                                         uint64_t step_count,
                                         const std::function<void(uint64_t)>& on_frame,
                                         size_t max_pairs = kMaxCheckedPairs);

}  // namespace sweepstake::cli
