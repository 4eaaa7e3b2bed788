// The prior store that several daemons share, in PostgreSQL. This header needs no headers of libpq.
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

// Maximum number of evidence increments in a group of updates that are committed together. A group
// costs as many round trips and disk syncs as a single update.
inline constexpr size_t kSharedGroupRows = 5'000;

// Checks the URL of a shared store. Error: INVALID_ARGUMENT (not a postgresql:// URL, or it
// contains a password, which --print-config would show).
absl::Status CheckStoreUrl(const std::string& url);

// Opens the store and the connection that reads it. Errors: those of OpenPostgresPriorStore,
// UNIMPLEMENTED (the daemon was built without libpq).
absl::StatusOr<OpenedStore> OpenSharedStore(const std::string& url,
                                            const priors::AuditLimits& audit_limits);

// Returns the key that signs the resume tokens of all daemons of the store, so that a session can
// continue at any of them. Stores and returns `own` if the store has no key yet. Errors:
// UNAVAILABLE. REQUIRES: `store` is from OpenSharedStore.
absl::StatusOr<std::string> SharedResumeKey(priors::PriorStore& store, const std::string& own);

// Copies the store in the data directory to the shared one, or back. Errors: those of
// postgres_migration.h, INVALID_ARGUMENT (the URL is empty), UNIMPLEMENTED.
absl::StatusOr<StoreContents> MigrateStore(const std::filesystem::path& directory,
                                           const std::string& url, bool to_shared,
                                           const OnMigrated& on_migrated);

}  // namespace sweepstake::storage
