// Opens the database file of the prior store: creates a missing one, migrates an older one, refuses
// every other.
//
// A file that exists is never re-created or adopted: an empty one (a lost copy, a full disk), one
// of another program and one of a newer version are errors, so that priors never turn silently
// empty. A new file is built beside its place and renamed into it, so that a crash leaves either no
// file or a whole one.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

inline constexpr int64_t kSqliteApplicationId = 0x53575031;  // "SWP1"

// Version of the schema this program writes.
int64_t SqliteSchemaVersion();

// A connection with every pragma set. Errors: UNAVAILABLE (cannot create, open or write), DATA_LOSS
// (empty, foreign or corrupt), FAILED_PRECONDITION (written by a newer version). Cost: reads the
// whole file once (quick_check).
absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const std::filesystem::path& path);

}  // namespace sweepstake::storage
