#include "engine_client/cli/trace/turn_order.h"

#include <numeric>
#include <utility>

namespace sweepstake::cli {

TurnOrder::TurnOrder(size_t contestant_count, size_t twin, uint64_t seed)
    : order_(contestant_count), twin_(twin), random_(seed) {
  std::iota(order_.begin(), order_.end(), size_t{0});
}

const std::vector<size_t>& TurnOrder::Next() {
  // Three contestants take six draws or so, more of them fewer.
  constexpr int kMostDraws = 1000;
  const size_t last = order_.back();
  for (int draw = 0; draw < kMostDraws; ++draw) {
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
