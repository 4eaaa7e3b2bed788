// Copies all that a prior store has from a data directory to PostgreSQL, and back: sources with
// what is known of them, revoked ones too, evidence, and the audit log. Sums are
// made anew from the rows, and are the same.
//
// Either all is there in the end, as the counts of rows on both sides say, or nothing; where it was
// it stays.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/backup/sqlite_backup.h"

namespace sweepstake::storage {

// Is told when a tenth more of a table's rows, or all, are there.
using OnMigrated = std::function<void(const std::string& table, uint64_t rows, uint64_t of)>;

// Errors: those of BackUpStore, DataDirectory::Open, CheckDelivered and OpenPostgresPriorStore,
// ALREADY_EXISTS (the store in PostgreSQL has sources).
absl::StatusOr<StoreContents> MigrateToPostgres(const std::filesystem::path& directory,
                                                const std::string& url,
                                                const OnMigrated& on_migrated);

// Errors: those of RestoreStore, CheckDelivered and OpenPostgresPriorStore, ALREADY_EXISTS (the
// directory has a database).
absl::StatusOr<StoreContents> MigrateFromPostgres(const std::string& url,
                                                  const std::filesystem::path& directory,
                                                  const OnMigrated& on_migrated);

}  // namespace sweepstake::storage
