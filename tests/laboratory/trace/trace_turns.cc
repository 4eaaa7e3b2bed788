#include "tests/laboratory/trace/trace_turns.h"

#include <algorithm>
#include <numeric>
#include <utility>

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

TurnOrder::TurnOrder(size_t contestant_count, size_t twin, uint64_t seed)
    : order_(contestant_count), twin_(twin), random_(seed) {
  std::iota(order_.begin(), order_.end(), size_t{0});
}

const std::vector<size_t>& TurnOrder::Next() {
  // Three contestants take some six draws, more contestants take fewer.
  constexpr int kMaxDraws = 1000;
  const size_t last = order_.back();
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    Shuffle();
    if (order_.size() < 3 || !HasTwinsTogether(last)) break;
  }
  return order_;
}

void TurnOrder::Shuffle() {
  for (size_t left = order_.size(); left > 1; --left) {
    std::swap(order_[left - 1], order_[random_.Below(left)]);
  }
}

bool TurnOrder::HasTwinsTogether(size_t before) const {
  for (const size_t contestant : order_) {
    if (AreTwins(before, contestant)) return true;
    before = contestant;
  }
  return false;
}

bool TurnOrder::AreTwins(size_t a, size_t b) const {
  const size_t control = order_.size() - 1;
  return (a == twin_ && b == control) || (a == control && b == twin_);
}

}  // namespace sweepstake::cli
