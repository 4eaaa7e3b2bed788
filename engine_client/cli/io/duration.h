// Parses durations (500ms, 60s, 15m, 1.5h), and formats times. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns the nanoseconds, from `min_ns` to 30 days. For other text returns kInvalidArgument with a
// message that describes the format.
Result<uint64_t> ParseDuration(std::string_view text, uint64_t min_ns = 1);

inline double Seconds(uint64_t ns) { return static_cast<double>(ns) / 1e9; }

// Returns a time since 1970 as UTC text, such as "2026-11-20 11:30:00". Empty if it is out of
// range.
std::string UtcText(int64_t unix_ms);

}  // namespace sweepstake::cli
