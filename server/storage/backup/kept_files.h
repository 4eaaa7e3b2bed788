// The files of a data directory, besides the database, that a restore needs: the tokens, the mark
// that there have been tokens, and the secret behind resume tokens. A backup contains them in its
// table kept_file, which is empty in a database in use.
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Adds the files of `directory` that exist to the copy. `scratch` names a file that does not exist;
// it is made and removed. Errors: UNAVAILABLE (a file cannot be read), DATA_LOSS (tokens.db is
// damaged).
absl::Status AddKeptFiles(const std::filesystem::path& directory,
                          const std::filesystem::path& scratch, SqliteDatabase& copy);

// Takes the files out of the copy. Writes those that `directory` lacks, readable by its owner only.
// Error: UNAVAILABLE.
absl::Status TakeKeptFiles(SqliteDatabase& copy, const std::filesystem::path& directory);

// Takes the files out of the copy, and writes none.
absl::Status DropKeptFiles(SqliteDatabase& copy);

}  // namespace sweepstake::storage
