// Options of a search with one arm, which never switches.
#pragma once

#include <string>
#include <string_view>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::test_support {

inline AdaptiveOptions OneArm(std::string_view arm, Executor* executor = nullptr) {
  return {.arms = {std::string(arm)}, .mode = Mode::kManual, .executor = executor};
}

}  // namespace sweepstake::test_support
