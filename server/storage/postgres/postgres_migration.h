// Copies a prior store from a data directory to PostgreSQL, and back: sources, including revoked
// ones, evidence, and the audit log. Sums are computed again from the rows, with the same result.
//
// On success the copy has all rows: their counts on both sides were compared. After an error
// nothing was copied. The original is never changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/backup/sqlite_backup.h"

namespace sweepstake::storage {

// Reports that `rows` of the `of` rows of `table` are copied. Called after each tenth of the rows,
// and after the last one.
using OnMigrated = std::function<void(const std::string& table, uint64_t rows, uint64_t of)>;

// Copies the directory's store to PostgreSQL. Errors: those of BackUpStore, DataDirectory::Open,
// CheckDelivered and OpenPostgresPriorStore, ALREADY_EXISTS (PostgreSQL's store has sources).
absl::StatusOr<StoreContents> MigrateToPostgres(const std::filesystem::path& directory,
                                                const std::string& url,
                                                const OnMigrated& on_migrated);

// Copies the store from PostgreSQL to the directory. Errors: those of RestoreStore, CheckDelivered
// and OpenPostgresPriorStore, ALREADY_EXISTS (the directory has a database).
absl::StatusOr<StoreContents> MigrateFromPostgres(const std::string& url,
                                                  const std::filesystem::path& directory,
                                                  const OnMigrated& on_migrated);

}  // namespace sweepstake::storage
