// Converts an update of a source to bytes (CBOR) and back, exactly to the last bit of its numbers.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

std::string UpdateText(const priors::SourceUpdate& update);
// Error: DATA_LOSS (the bytes are not an update).
absl::StatusOr<priors::SourceUpdate> UpdateIn(const std::string& text);

}  // namespace sweepstake::storage
