// The part of a request's target after the question mark. Pure.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::web {

// Returns the value of NAME=VALUE among the parts between ampersands, decoded; empty without one.
// Error: INVALID_ARGUMENT (a percent sign without two hexadecimal digits).
absl::StatusOr<std::string> QueryValue(std::string_view query, std::string_view name);

}  // namespace sweepstake::web
