// Options of a search with one arm, which never switches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::test_support {

inline AdaptiveOptions OneArm(std::string_view arm, Executor* executor = nullptr,
                              uint64_t max_pairs = 0) {
  return {.arms = {std::string(arm)},
          .mode = Mode::kManual,
          .executor = executor,
          .max_pairs = max_pairs};
}

// A maximum for tests of one arm. This number of boxes in one place exceeds it.
inline constexpr uint64_t kMaxPairs = 10'000;
inline constexpr size_t kTooManyBoxes = 150;

}  // namespace sweepstake::test_support
