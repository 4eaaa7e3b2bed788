// The prior store on SQLite: one file with a write-ahead log and synchronous commits. Used by one
// thread at a time.
//
// Before each change the store checks that its file and the write-ahead log are still at their
// paths. Data in a removed file would be lost when the process ends, so nothing is written until
// the files are back.
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

// Opens a second connection to the file of an open store, which only reads. It must be closed
// before the store. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<ReadConnection>> OpenSqliteReadConnection(
    const std::filesystem::path& path);

// Changes the limits of the audit log, and removes rows beyond them. For SQLite it also changes the
// maximum size of the file, to at least the file's present size. REQUIRES: OpenSqlitePriorStore or
// OpenPostgresPriorStore returned `store`.
absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes);

// Returns how many commits of sources the store has. Errors: UNAVAILABLE, DATA_LOSS. REQUIRES:
// OpenSqlitePriorStore returned `store`.
absl::StatusOr<uint64_t> CountCommits(priors::PriorStore& store);

// Returns the bytes of the file that are in use. Removed rows free bytes. Errors: UNAVAILABLE,
// DATA_LOSS. REQUIRES: OpenSqlitePriorStore returned `store`.
absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store);

// Writes the committed content of the store to `file`, replacing an existing one. Works even if the
// store's own file was removed. First moves the content of the write-ahead log into the store's
// file, so that SQLite does not apply it to a new file at the same path. `edit` changes the copy
// before it appears at `file`. Errors: UNAVAILABLE, DATA_LOSS. REQUIRES: OpenSqlitePriorStore
// returned `store`.
absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit);

}  // namespace sweepstake::storage
