// Decodes the parts of a request's target: names in its path, and its query. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::web {

// Returns the text with each percent sign and its two digits replaced by the byte. Error:
// INVALID_ARGUMENT (a percent sign without two hexadecimal digits).
absl::StatusOr<std::string> PercentDecoded(std::string_view text);

// Returns the decoded value of NAME=VALUE in a query; empty if it is absent. Error: that of
// PercentDecoded.
absl::StatusOr<std::string> QueryValue(std::string_view query, std::string_view name);

}  // namespace sweepstake::web
