// Copies of the prior store, made while a daemon runs, verified, and restored. A damaged row of the
// store is left out of its copies. A row is damaged if its hash is wrong (sqlite_schema.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// The numbers of rows of a database.
struct StoreContents {
  int64_t scene_count = 0;
  int64_t source_count = 0;  // those with evidence
  int64_t record_count = 0;
  int64_t audit_row_count = 0;
  int64_t damaged_row_count = 0;  // rows of the original that are left out of this backup
};

// Reads the whole database and changes nothing. Errors: NOT_FOUND (the file is missing),
// UNAVAILABLE (cannot open it), DATA_LOSS (not a whole database of ours, damaged rows, or wrong
// sums), FAILED_PRECONDITION (it has another schema version).
absl::StatusOr<StoreContents> VerifyStore(const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Removes the damaged rows from a copy: evidence, and sources with all of their evidence. Computes
// the sums and numbers of sources that this changes, or that are damaged themselves. Returns the
// number of damaged rows. Changes nothing and returns 0 if there are none, or if the copy has other
// faults.
int64_t LeaveOutDamagedRows(SqliteDatabase& copy);

// Writes the database of a data directory, in use or not, to a new file without damaged rows, and
// verifies the file. Another thread may set `stop` meanwhile. Errors: those of VerifyStore,
// ALREADY_EXISTS, CANCELLED (by `stop`), NOT_FOUND (the directory has no database).
absl::StatusOr<StoreContents> BackUpStore(const std::filesystem::path& directory,
                                          const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Error: ALREADY_EXISTS (the data directory has a database).
absl::Status CheckNoDatabase(const std::filesystem::path& directory);

// Verifies the file and copies it into a data directory without a database that no daemon uses.
// Makes the directory if it is missing. Errors: those of VerifyStore and of DataDirectory::Open,
// ALREADY_EXISTS.
absl::StatusOr<StoreContents> RestoreStore(const std::filesystem::path& file,
                                           const std::filesystem::path& directory);

}  // namespace sweepstake::storage
