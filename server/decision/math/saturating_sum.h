// Sums that stay at the largest value rather than wrap. Pure.
#pragma once

#include <concepts>
#include <limits>

namespace sweepstake::decision {

// REQUIRES: addend >= 0.
template <std::integral Number>
Number SaturatingSum(Number value, Number addend) {
  constexpr Number kMost = std::numeric_limits<Number>::max();
  return value > kMost - addend ? kMost : value + addend;
}

}  // namespace sweepstake::decision
