// The prior store on SQLite: one file, write-ahead log, synchronous commits. One thread at a time.
//
// Cost: a commit of 100 increments takes one fsync; LoadPriors and LoadScene read one row per key
// and source.
#pragma once

#include <filesystem>
#include <memory>

#include "server/priors/prior_store.h"

namespace sweepstake::storage {

// Errors as in OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits = {});

}  // namespace sweepstake::storage
