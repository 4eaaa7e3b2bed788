// Factors between the protocol's units and the library's.
#pragma once

#include <cstdint>

namespace sweepstake {

inline constexpr uint64_t kNsPerMs = 1'000'000;

}  // namespace sweepstake
