// The prior store that several daemons share, as those who know no libpq use it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/postgres/postgres_migration.h"

namespace sweepstake::storage {

// The increments of a group of commits: so many share the round trips and the sync of one.
inline constexpr size_t kSharedGroupRows = 5'000;

// Returns what is wrong with the text as the URL of such a store: it is no postgresql:// URL, or
// has a password, which configurations print.
absl::Status CheckStoreUrl(const std::string& url);

// Opens the store and the connection that reads it. Errors: those of OpenPostgresPriorStore,
// UNIMPLEMENTED (the daemon was built without libpq).
absl::StatusOr<OpenedStore> OpenSharedStore(const std::string& url,
                                            const priors::AuditLimits& audit_limits);

// What the store offers besides what every store does. REQUIRES: it is of OpenSharedStore.
absl::StatusOr<std::string> SharedResumeKey(priors::PriorStore& store, const std::string& own);
void LimitSharedStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits);

// Copies what the store in the data directory has to the shared one, or back
// (postgres_migration.h). Errors: those of there, INVALID_ARGUMENT (the URL is empty),
// UNIMPLEMENTED.
absl::StatusOr<StoreContents> MigrateToShared(const std::filesystem::path& directory,
                                              const std::string& url,
                                              const OnMigrated& on_migrated);
absl::StatusOr<StoreContents> MigrateFromShared(const std::string& url,
                                                const std::filesystem::path& directory,
                                                const OnMigrated& on_migrated);

}  // namespace sweepstake::storage
