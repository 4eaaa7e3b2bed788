#include "tests/laboratory/game/pair_oracle.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>

#include "engine_client/math/hash.h"

namespace sweepstake::cli {

bool PairOracle::Sweep(size_t max_pairs, std::span<const Aabb> boxes) {
  pairs_.clear();
  order_.clear();
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    if (IsValid(boxes[i])) order_.push_back(i);
  }
  std::sort(order_.begin(), order_.end(),
            [&](uint32_t a, uint32_t b) { return boxes[a].min[0] < boxes[b].min[0]; });
  for (auto first = order_.begin(); first != order_.end(); ++first) {
    for (auto second = first + 1; second != order_.end(); ++second) {
      if (boxes[*second].min[0] > boxes[*first].max[0]) break;
      if (!Overlap(boxes[*first], boxes[*second])) continue;
      if (pairs_.size() == max_pairs) return false;
      pairs_.push_back({std::min(*first, *second), std::max(*first, *second)});
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  return true;
}

std::span<const OverlapPair> PairOracle::Find(std::span<const Aabb> boxes) {
  Sweep(std::numeric_limits<size_t>::max(), boxes);
  return pairs_;
}

Result<std::span<const OverlapPair>> PairOracle::FindUpTo(size_t max_pairs,
                                                          std::span<const Aabb> boxes) {
  if (Sweep(max_pairs, boxes)) return std::span<const OverlapPair>(pairs_);
  return Status(StatusCode::kResourceExhausted,
                "more than " + std::to_string(max_pairs) + " pairs overlap");
}

PairDifference ComparePairs(std::span<OverlapPair> found, std::span<const OverlapPair> right) {
  std::sort(found.begin(), found.end());
  PairDifference difference;
  if (std::equal(found.begin(), found.end(), right.begin(), right.end())) return difference;
  // set_difference keeps surplus repetitions, so a pair that is found twice appears once in
  // `extra`.
  std::set_difference(found.begin(), found.end(), right.begin(), right.end(),
                      std::back_inserter(difference.extra));
  std::set_difference(right.begin(), right.end(), found.begin(), found.end(),
                      std::back_inserter(difference.missing));
  return difference;
}

PairFingerprint FingerprintOf(std::span<const OverlapPair> pairs) {
  PairFingerprint fingerprint;
  fingerprint.count = pairs.size();
  for (const OverlapPair& pair : pairs) {
    const uint64_t key = uint64_t{pair.a} << 32 | pair.b;
    fingerprint.sums[0] += math::Mix64(key + math::kGoldenGamma);
    fingerprint.sums[1] += math::Mix64(~key);
  }
  return fingerprint;
}

}  // namespace sweepstake::cli
