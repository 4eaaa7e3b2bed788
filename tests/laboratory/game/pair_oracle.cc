#include "tests/laboratory/game/pair_oracle.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "engine_client/math/hash.h"

namespace sweepstake::cli {
namespace {

// One arm and the result of its check so far.
struct Candidate {
  BroadPhase& backend;
  ArmCheck check;
  PairBuffer pairs;
};

void Take(BroadPhase& backend, std::span<const Aabb> boxes, bool first) {
  if (first) {
    backend.Build(boxes);
  } else {
    backend.Update(boxes);
  }
}

void Judge(Candidate& candidate, uint64_t frame, std::span<const OverlapPair> right) {
  candidate.pairs.Clear();
  candidate.backend.FindPairs(candidate.pairs);
  PairDifference difference = ComparePairs(candidate.pairs.pairs(), right);
  if (!difference.empty()) {
    candidate.check.first_difference = FirstDifference{frame, std::move(difference)};
    return;
  }
  ++candidate.check.frame_count;
  candidate.check.pair_count += right.size();
}

}  // namespace

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
  // A pair that is found twice appears once in `extra`, because set_difference keeps surplus
  // repetitions.
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

Result<std::vector<ArmCheck>> CheckScene(Scene& scene,
                                         std::span<const std::unique_ptr<BroadPhase>> arms,
                                         uint64_t step_count,
                                         const std::function<void(uint64_t)>& on_frame,
                                         size_t max_pairs) {
  std::vector<Candidate> candidates;
  candidates.reserve(arms.size());
  for (const auto& arm : arms)
    candidates.push_back({*arm, {std::string(arm->name()), 0, 0, {}}, {}});
  PairOracle oracle;
  for (uint64_t frame = 0; frame <= step_count; ++frame) {
    if (frame > 0) scene.Step();
    const std::span<const Aabb> boxes = scene.aabbs();
    const auto right = oracle.FindUpTo(max_pairs, boxes);
    if (!right.ok()) {
      return Status(right.status().code(),
                    "frame " + std::to_string(frame) +
                        " has too many pairs to check: " + right.status().message());
    }
    for (Candidate& candidate : candidates) {
      if (candidate.check.first_difference) continue;
      Take(candidate.backend, boxes, frame == 0);
      Judge(candidate, frame, *right);
    }
    on_frame(frame + 1);
  }
  std::vector<ArmCheck> checks;
  checks.reserve(candidates.size());
  for (Candidate& candidate : candidates) checks.push_back(std::move(candidate.check));
  return checks;
}

}  // namespace sweepstake::cli
