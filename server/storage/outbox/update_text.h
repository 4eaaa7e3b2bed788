// Converts an update of a source to text (JSON) and back, exactly to the last bit of its numbers.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

// REQUIRES: the strings are UTF-8; other bytes are lost.
std::string UpdateText(const priors::SourceUpdate& update);
// Error: DATA_LOSS (the text is not an update).
absl::StatusOr<priors::SourceUpdate> UpdateIn(const std::string& text);

}  // namespace sweepstake::storage
