// The parts of a request's target: names in its path, and what is after the question mark. Pure.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::web {

// Returns the text with the byte in place of each percent sign and its two digits. Error:
// INVALID_ARGUMENT (a percent sign without two hexadecimal digits).
absl::StatusOr<std::string> PercentDecoded(std::string_view text);

// Returns the value of NAME=VALUE among the parts between ampersands, decoded; empty without one.
// Error: as PercentDecoded.
absl::StatusOr<std::string> QueryValue(std::string_view query, std::string_view name);

}  // namespace sweepstake::web
