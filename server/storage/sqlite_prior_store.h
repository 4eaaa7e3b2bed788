// The prior store on SQLite: one file with a write-ahead log and synchronous commits. Used by one
// thread at a time.
//
// Before each change the store checks that the file and its log still have their names, because
// data in a file without a name is lost with the process. Nothing is written until they are back.
//
// A commit takes one fsync, for any number of increments.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Opens the store. Its file does not grow beyond `max_bytes` (0: any size); commits that need more
// return UNAVAILABLE. `on_sync`, if any, is called on the using thread with the duration of each
// fsync of the write-ahead log. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits = {},
    uint64_t max_bytes = 0, std::function<void(std::chrono::nanoseconds)> on_sync = {});

// Opens a new store in memory, which is lost when it is destroyed: for tests.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenMemoryPriorStore(
    const priors::AuditLimits& audit_limits = {});

// Opens a connection that only reads, beside the store of that file. It must end before the store,
// and be opened again with it. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<ReadConnection>> OpenSqliteReadConnection(
    const std::filesystem::path& path);

// Changes the limits of the audit log, whose rows beyond them are removed, and the maximum size of
// the file, at least to its present size. PostgreSQL has no file to limit. REQUIRES: `store` is of
// OpenSqlitePriorStore or OpenPostgresPriorStore.
absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes);

// Returns the bytes of the file that are in use. Removed rows free bytes. Errors: UNAVAILABLE,
// DATA_LOSS. REQUIRES: `store` is of OpenSqlitePriorStore.
absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store);

// Writes all that is committed to `file`, replacing an existing one, even if the store's own file
// has no name any more. Moves the log into the store's file, so that the log beside a new file of
// that name is empty. The file appears after `edit`. Errors: UNAVAILABLE, DATA_LOSS. REQUIRES:
// `store` is of OpenSqlitePriorStore.
absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit);

}  // namespace sweepstake::storage
