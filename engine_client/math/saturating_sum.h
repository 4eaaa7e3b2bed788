// A sum that stays at the maximum instead of wrapping around. Pure.
#pragma once

#include <concepts>
#include <limits>

namespace sweepstake::decision {

// Returns value + addend, or the maximum if that is too large. REQUIRES: addend >= 0.
template <std::integral Number>
Number SaturatingSum(Number value, Number addend) {
  constexpr Number kMax = std::numeric_limits<Number>::max();
  return value > kMax - addend ? kMax : value + addend;
}

}  // namespace sweepstake::decision
