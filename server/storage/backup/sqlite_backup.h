// Copies the SQLite prior store while a daemon runs, verifies copies, and restores them. Copies
// leave out damaged rows, whose stored hash does not match their content (sqlite_schema.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Row counts of a database.
struct StoreContents {
  int64_t scene_count = 0;
  int64_t source_count = 0;  // sources with evidence
  int64_t record_count = 0;
  int64_t audit_row_count = 0;
  std::vector<std::string> kept_files = {};  // kept_files.h
  int64_t damaged_row_count = 0;  // damaged rows of the original, which this copy leaves out
};

// Reads the whole database and changes nothing. Errors: NOT_FOUND (the file is missing),
// UNAVAILABLE (cannot open it), DATA_LOSS (not a complete prior database, damaged rows, or wrong
// sums), FAILED_PRECONDITION (it has another schema version).
absl::StatusOr<StoreContents> VerifyStore(const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Removes damaged evidence from a copy, and damaged sources with all of their evidence. Computes
// the affected sums and source counts again, and also the sums of damaged keys and scenes. Returns
// the number of damaged rows. Changes nothing and returns 0 if there are none, or if SQLite's
// integrity check finds a fault.
int64_t LeaveOutDamagedRows(SqliteDatabase& copy);

// Copies the database of a data directory to a new file without damaged rows, adds the other files
// that a restore needs (kept_files.h), and verifies the file. A daemon may be using the database.
// Another thread can set `stop` to cancel the backup. Errors: those of VerifyStore, ALREADY_EXISTS,
// CANCELLED (by `stop`), NOT_FOUND (the directory has no database).
absl::StatusOr<StoreContents> BackUpStore(const std::filesystem::path& directory,
                                          const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Error: ALREADY_EXISTS (the data directory has a database).
absl::Status CheckNoDatabase(const std::filesystem::path& directory);

// Verifies the file and copies it into a data directory, with the kept files that the directory
// lacks. The directory must have no database, and no daemon may use it. Makes the directory if it
// is missing. Errors: those of VerifyStore and of DataDirectory::Open, ALREADY_EXISTS.
absl::StatusOr<StoreContents> RestoreStore(const std::filesystem::path& file,
                                           const std::filesystem::path& directory);

}  // namespace sweepstake::storage
