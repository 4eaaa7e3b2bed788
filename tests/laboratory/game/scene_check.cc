#include "tests/laboratory/game/scene_check.h"

#include <string>
#include <utility>

namespace sweepstake::cli {
namespace {

// One arm while it is checked.
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
