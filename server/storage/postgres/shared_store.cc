#include "server/storage/postgres/shared_store.h"

#include <utility>

#include "server/storage/sql/sql_prior_store.h"

#ifdef SWEEPSTAKE_WITH_POSTGRES
#include "server/storage/postgres/postgres_prior_store.h"
#endif

namespace sweepstake::storage {
absl::Status CheckStoreUrl(const std::string& url) {
  const size_t scheme = url.find("://");
  const std::string name = url.substr(0, scheme);
  if (scheme == std::string::npos || (name != "postgresql" && name != "postgres")) {
    return absl::InvalidArgumentError(
        "expected a URL such as postgresql://sweepstake@db.example:5432/sweepstake; without a URL "
        "the priors are in the file priors.db in `data`");
  }
  const std::string rest = url.substr(scheme + 3);
  const std::string server = rest.substr(0, rest.find_first_of("/?"));
  const size_t at = server.rfind('@');
  if ((at != std::string::npos && server.find(':') < at) ||
      rest.find("password=") != std::string::npos) {
    return absl::InvalidArgumentError(
        "expected a URL without a password, which other users could read; write the password into "
        "a file and name that in PGPASSFILE");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> SharedResumeKey(priors::PriorStore& store, const std::string& own) {
  SqlDatabase& database = static_cast<SqlPriorStore&>(store).database();
  std::string key;
  absl::Status status = InTransaction(database, [&] {
    return database.ForEachRow(
        "UPDATE store SET resume_key = coalesce(resume_key, ?1) RETURNING resume_key",
        [&](const SqlRow& row) { key = row.Bytes(0); }, SqlBytes{own});
  });
  if (!status.ok()) return status;
  return key;
}

#ifdef SWEEPSTAKE_WITH_POSTGRES
absl::StatusOr<OpenedStore> OpenSharedStore(const std::string& url,
                                            const priors::AuditLimits& audit_limits) {
  auto store = OpenPostgresPriorStore(url, audit_limits);
  if (!store.ok()) return store.status();
  return OpenedStore{.store = *std::move(store),
                     .reads = OpenPostgresReadConnection(url),
                     .damage = {},
                     .file = {}};
}

absl::StatusOr<StoreContents> MigrateStore(const std::filesystem::path& directory,
                                           const std::string& url, bool to_shared,
                                           const OnMigrated& on_migrated) {
  if (url.empty()) {
    return absl::InvalidArgumentError(
        "name the shared store with --store postgresql://USER@HOST/DATABASE");
  }
  return to_shared ? MigrateToPostgres(directory, url, on_migrated)
                   : MigrateFromPostgres(url, directory, on_migrated);
}
#else
namespace {

absl::Status NotBuilt() {
  return absl::UnimplementedError(
      "store: this daemon was built without libpq; install libpq-dev and build it again");
}

}  // namespace

absl::StatusOr<OpenedStore> OpenSharedStore(const std::string& /*url*/,
                                            const priors::AuditLimits& /*limits*/) {
  return NotBuilt();
}

absl::StatusOr<StoreContents> MigrateStore(const std::filesystem::path& /*directory*/,
                                           const std::string& /*url*/, bool /*to_shared*/,
                                           const OnMigrated& /*on_migrated*/) {
  return NotBuilt();
}
#endif

}  // namespace sweepstake::storage
