// The prior store on SQLite: one file with a write-ahead log and synchronous commits. Used by one
// thread at a time.
//
// A commit takes one fsync, however many increments it has. Import and Revoke add the sums of the
// keys they change anew, from one row per source. What it reads it reads as SqlitePriorReader does.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/priors/prior_store.h"

namespace sweepstake::storage {

// Opens the store, whose file does not grow beyond `max_bytes` (0: any size): then commits that
// need more are UNAVAILABLE. `on_sync`, if there is one, is told on the using thread how long each
// fsync of the write-ahead log took. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits = {},
    uint64_t max_bytes = 0, std::function<void(std::chrono::nanoseconds)> on_sync = {});

// Changes how large the file may grow, at least to its present size. REQUIRES: `store` is of
// OpenSqlitePriorStore.
absl::Status LimitStoreSize(priors::PriorStore& store, uint64_t max_bytes);

}  // namespace sweepstake::storage
