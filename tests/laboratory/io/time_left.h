// Shows the share of long work that is done, with an estimate of the time that is left.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Returns "1 h 12 min", "3 min" or "40 s".
std::string DurationText(double seconds);

// Returns a callback that shows the finished share, its text and an estimate of the time that is
// left. The estimate assumes the mean speed since this call. REQUIRES: `progress` outlives the
// callback.
std::function<void(double share, const std::string& text)> OnShareWithTimeLeft(Progress& progress);

}  // namespace sweepstake::cli
