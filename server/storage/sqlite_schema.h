// Opens the database file of the prior store. A missing file is created. A file of another schema
// version is refused.
//
// The file store-id beside the database contains the id of the database that was there at the last
// start. If that database is missing or has another id, opening fails and changes neither file.
//
// An existing file is never replaced by a new database. An empty file (from an interrupted copy or
// a full disk) and a file of another program are errors, so that priors are never lost unnoticed. A
// new database is built under another name and then renamed, so that a crash leaves a complete file
// or none.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

inline constexpr int64_t kSqliteApplicationId = 0x53575031;  // "SWP1"

// The tables whose rows have a hash.
inline constexpr const char* kHashedTables[] = {
    "source", "scene", "evidence_key", "evidence", "quarantined_evidence", "kept_file"};

// Returns the path of the file store-id beside the database `path`.
std::filesystem::path StoreIdFile(const std::filesystem::path& path);

// Checks that the file is a prior database of this schema version. Errors: DATA_LOSS (the file
// belongs to another program or has no schema), FAILED_PRECONDITION (it has another schema
// version).
absl::Status CheckPriorDatabase(SqliteDatabase& database, const std::filesystem::path& path);

// Runs SQLite's checks, which read the whole file. Errors: UNAVAILABLE (the disk cannot read it),
// DATA_LOSS (damaged).
absl::Status CheckPages(SqliteDatabase& database, const std::filesystem::path& path);

// Reads all rows that have a hash, and returns how many are damaged.
absl::StatusOr<int64_t> CountDamagedRows(SqliteDatabase& database);

// Opens the database, and creates it if it is missing. Makes durable what an earlier process left
// in the write-ahead log, then checks the whole file (CheckPages). Errors: UNAVAILABLE (cannot
// create, open or write), DATA_LOSS (the file was there and is missing, is empty or corrupt, or
// belongs to another program), FAILED_PRECONDITION (another schema version, or another database
// than at the last start; the message gives advice).
absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const std::filesystem::path& path);

// Returns a connection to a new database in memory, which is lost when the connection ends.
absl::StatusOr<SqliteDatabase> OpenPriorDatabaseInMemory();

// Returns a second connection with the same pragmas, which only reads. REQUIRES: a connection of
// OpenPriorDatabase is open and is closed later, because only that one can move the write-ahead log
// into the file.
absl::StatusOr<SqliteDatabase> OpenPriorDatabaseToRead(const std::filesystem::path& path);

}  // namespace sweepstake::storage
