#include "engine_client/cli/trace/arm_pace.h"

#include <algorithm>

namespace sweepstake::cli {

ArmPace::ArmPace(std::span<const uint64_t> frame_ns) {
  for (const uint64_t ns : frame_ns) arms_.push_back({.frame_ns = ns});
}

ArmTurn ArmPace::TurnOf(size_t arm, size_t object_count) const {
  const auto cheapest =
      std::min_element(arms_.begin(), arms_.end(),
                       [](const Arm& a, const Arm& b) { return a.frame_ns < b.frame_ns; });
  const Arm& asked = arms_[arm];
  if (asked.frame_ns <= kSparseRatio * cheapest->frame_ns) return ArmTurn::kEveryFrame;
  const bool affordable =
      static_cast<double>(asked.sparse_ns) <= kSparseShare * static_cast<double>(total_ns_);
  const bool fewer =
      static_cast<double>(object_count) < kFewerRatio * static_cast<double>(asked.object_count);
  return affordable || fewer ? ArmTurn::kLastFrame : ArmTurn::kNone;
}

void ArmPace::Note(size_t arm, ArmTurn turn, size_t object_count, uint64_t frame_ns,
                   uint64_t spent_ns) {
  Arm& noted = arms_[arm];
  noted.frame_ns = frame_ns;
  noted.object_count = object_count;
  if (turn == ArmTurn::kLastFrame) noted.sparse_ns += spent_ns;
  total_ns_ += spent_ns;
}

}  // namespace sweepstake::cli
