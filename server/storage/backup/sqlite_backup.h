// Copies of the prior store: made while a daemon runs, checked, and put back. A copy is whole
// though the store has rows that are not what was written: those are left out of it.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// What a database has.
struct StoreContents {
  int64_t scene_count = 0;
  int64_t source_count = 0;  // those with evidence
  int64_t record_count = 0;
  int64_t audit_row_count = 0;
  int64_t damaged_row_count = 0;  // of the database that this is a backup of
};

// Reads all of a database and changes nothing. Errors: NOT_FOUND (there is no such file),
// UNAVAILABLE (cannot open it), DATA_LOSS (not a whole database of ours, its rows are not what was
// written, or its sums are not those of its rows), FAILED_PRECONDITION (it has
// another schema version).
absl::StatusOr<StoreContents> VerifyStore(const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Leaves the rows that are not what was written out of a copy: evidence, and sources with all of
// theirs. The sums and the numbers of sources that these change, or that are wrong themselves, are
// made anew. Returns how many rows were wrong; changes nothing and returns 0 if none was, or if the
// copy has other faults.
int64_t LeaveOutDamagedRows(SqliteDatabase& copy);

// Writes the database of a data directory, in use or not, to a new file, without the rows that are
// not what was written, and verifies that. If there is a flag `stop` it may be set meanwhile.
// Errors: those of VerifyStore, ALREADY_EXISTS, CANCELLED (by `stop`), NOT_FOUND (the directory has
// no database).
absl::StatusOr<StoreContents> BackUpStore(const std::filesystem::path& directory,
                                          const std::filesystem::path& file,
                                          const std::atomic<bool>* stop = nullptr);

// Error: ALREADY_EXISTS (the data directory has a database).
absl::Status CheckNoDatabase(const std::filesystem::path& directory);

// Verifies the file and copies it into a data directory that has no database and that no daemon
// uses; makes the directory if it is missing. Errors: those of VerifyStore and of
// DataDirectory::Open, ALREADY_EXISTS.
absl::StatusOr<StoreContents> RestoreStore(const std::filesystem::path& file,
                                           const std::filesystem::path& directory);

}  // namespace sweepstake::storage
