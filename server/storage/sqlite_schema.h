// Opens the database file of the prior store. A missing file is created. A file of another schema
// version is refused.
//
// The file store-id beside it names the database that was there at the last start. If that database
// is missing, or another is in its place, both files stay as they are and opening fails.
//
// A file that exists is never created again or taken over: an empty file (a lost copy, a full disk)
// and one of another program are errors, so that priors never become empty silently. A new file is
// built beside its place and renamed into it, so that a crash leaves a complete file or none.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

inline constexpr int64_t kSqliteApplicationId = 0x53575031;  // "SWP1"

// The tables whose rows have a hash.
inline constexpr const char* kHashedTables[] = {"source", "scene", "evidence_key", "evidence",
                                                "quarantined_evidence"};

// The file that names the database.
std::filesystem::path StoreIdFile(const std::filesystem::path& path);

// Errors: DATA_LOSS (the file belongs to another program or has no schema), FAILED_PRECONDITION (it
// has another schema version).
absl::Status CheckPriorDatabase(SqliteDatabase& database, const std::filesystem::path& path);

// Reads the whole file. Errors: UNAVAILABLE (the disk cannot read it), DATA_LOSS (damaged).
absl::Status CheckPages(SqliteDatabase& database, const std::filesystem::path& path);

// Reads all rows that have a hash, and returns how many are damaged.
absl::StatusOr<int64_t> CountDamagedRows(SqliteDatabase& database);

// Returns a connection with every pragma set. It makes durable what an earlier process left in the
// log, then reads the whole file once (CheckPages). Errors: UNAVAILABLE (cannot create, open or
// write), DATA_LOSS (lost, empty, foreign or corrupt), FAILED_PRECONDITION (another schema version,
// or another database than at the last start; the message says what to do).
absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const std::filesystem::path& path);

// Returns a connection to a new database in memory, which ends with it.
absl::StatusOr<SqliteDatabase> OpenPriorDatabaseInMemory();

// Returns a second connection with the same pragmas, which only reads. REQUIRES: one of
// OpenPriorDatabase is open, and closes later, because only that one can move the log into the
// file.
absl::StatusOr<SqliteDatabase> OpenPriorDatabaseToRead(const std::filesystem::path& path);

}  // namespace sweepstake::storage
