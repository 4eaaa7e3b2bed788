// The prior store on SQLite: one file with a write-ahead log and synchronous commits. Used by one
// thread at a time.
//
// Before each change it is looked whether the file and its log still are what their names mean:
// what is written to a file without a name is lost with the process. Then nothing is written until
// they are back.
//
// A commit takes one fsync, however many increments it has. Import and Revoke add the sums of the
// keys they change anew, from one row per source. What it reads it reads as SqlitePriorReader does.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Opens the store, whose file does not grow beyond `max_bytes` (0: any size): then commits that
// need more are UNAVAILABLE. `on_sync`, if there is one, is told on the using thread how long each
// fsync of the write-ahead log took. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits = {},
    uint64_t max_bytes = 0, std::function<void(std::chrono::nanoseconds)> on_sync = {});

// Opens a new store in memory, which is lost when it is destroyed: for tests.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenMemoryPriorStore(
    const priors::AuditLimits& audit_limits = {});

// Changes the limits of the audit log, whose rows beyond them are removed, and how large the file
// may grow, at least to its present size. REQUIRES: `store` is of OpenSqlitePriorStore.
absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes);

// Returns how many bytes of what the file may grow to are in use; what was removed is used again.
// Errors: UNAVAILABLE, DATA_LOSS. REQUIRES: `store` is of OpenSqlitePriorStore.
absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store);

// Writes all that is committed to `file`, in place of one that is there, also where the store's own
// has no name any more; and takes the log into the store's file, so that an empty log stays beside
// whatever has its name now. The file appears after `edit`. Errors: UNAVAILABLE, DATA_LOSS.
// REQUIRES: `store` is of OpenSqlitePriorStore.
absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit);

}  // namespace sweepstake::storage
