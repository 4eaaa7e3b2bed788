// Sums that stay at the maximum rather than wrap. Pure.
#pragma once

#include <concepts>
#include <limits>

namespace sweepstake::decision {

// REQUIRES: addend >= 0.
template <std::integral Number>
Number SaturatingSum(Number value, Number addend) {
  constexpr Number kMax = std::numeric_limits<Number>::max();
  return value > kMax - addend ? kMax : value + addend;
}

}  // namespace sweepstake::decision
