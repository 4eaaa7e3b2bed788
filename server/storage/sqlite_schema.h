// Opens the database file of the prior store: a missing file is created, an older one is migrated,
// and every other one is refused.
//
// The file store-id beside it says which database was there at the last start: if that one is
// missing, or another is in its place, both are left alone.
//
// Each row of the evidence has a hash of its values (row_hash of sqlite_database.h), because
// SQLite's own checks miss a value that was changed on the disk. `content_hash` is derived from the
// values at each use; a row whose `hash` differs is damaged.
//
// Before a migration the file is copied to NAME.schema-N, for its version N.
//
// A file that exists is never created again or taken over. An empty file (a lost copy, a full
// disk), one of another program and one of a newer version are errors, so that priors never become
// empty silently. A new file is built beside its place and renamed into it, so that a crash leaves
// either no file or a complete one.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

inline constexpr int64_t kSqliteApplicationId = 0x53575031;  // "SWP1"

// The file that says which database was there.
std::filesystem::path StoreIdFile(const std::filesystem::path& path);

// The version of the schema that this program writes.
int64_t SqliteSchemaVersion();

// Returns the version of a file's schema. Errors: DATA_LOSS (it belongs to another program or has
// no schema), FAILED_PRECONDITION (written by a newer version).
absl::StatusOr<int64_t> CheckPriorDatabase(SqliteDatabase& database,
                                           const std::filesystem::path& path);

// Reads the whole file. Errors: UNAVAILABLE (the disk cannot read it), DATA_LOSS (damaged).
absl::Status CheckPages(SqliteDatabase& database, const std::filesystem::path& path);

// The version from which on rows have hashes.
inline constexpr int64_t kFirstVersionWithHashes = 7;

// Reads the rows that have a hash, and returns how many are damaged.
absl::StatusOr<int64_t> CountDamagedRows(SqliteDatabase& database);

// Returns a connection with every pragma set. Errors: UNAVAILABLE (cannot create, open or write),
// DATA_LOSS (lost, empty, foreign or corrupt), FAILED_PRECONDITION (written by a newer version, or
// not the one that was here; the message says what to do). It reads
// the whole file once (CheckPages), after what an earlier process has left in the log is durable.
absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const std::filesystem::path& path);

// Returns another connection, which only reads, with the same pragmas. REQUIRES: one of
// OpenPriorDatabase is open, and closes later: only that one can take the log into the file.
absl::StatusOr<SqliteDatabase> OpenPriorDatabaseToRead(const std::filesystem::path& path);

}  // namespace sweepstake::storage
