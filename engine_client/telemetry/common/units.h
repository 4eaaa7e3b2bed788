// Conversion factors between the units of the protocol and of the library.
#pragma once

#include <cstdint>

namespace sweepstake {

inline constexpr uint64_t kNsPerMs = 1'000'000;

}  // namespace sweepstake
