// Durations: read as people write them (500ms, 60s, 15m, 1.5h), and in seconds. Pure functions.
#pragma once

#include <cstdint>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns nanoseconds, above 0 and at most 30 days. The message of kInvalidArgument says what is
// accepted.
Result<uint64_t> ParseDuration(std::string_view text);

inline double Seconds(uint64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace sweepstake::cli
