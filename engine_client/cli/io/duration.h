// Reads durations as people write them: 500ms, 60s, 15m, 1.5h. A pure function.
#pragma once

#include <cstdint>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns nanoseconds, above 0 and at most 30 days. The message of kInvalidArgument says what is
// accepted.
Result<uint64_t> ParseDuration(std::string_view text);

}  // namespace sweepstake::cli
