// What one step of FoldSources (sqlite_prior_store.h) does in its transaction.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_prior_statements.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::storage {

absl::StatusOr<FoldStep> FoldRows(PriorStatements& statements, const FoldPlace& after,
                                  uint64_t last_unix_s, uint32_t row_count);

}  // namespace sweepstake::storage
