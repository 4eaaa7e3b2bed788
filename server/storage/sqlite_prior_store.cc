#include "server/storage/sqlite_prior_store.h"

#include <utility>

#include "server/storage/sql/sql_prior_reader.h"
#include "server/storage/sql/sql_prior_store.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

SqlPriorStore& StoreOf(priors::PriorStore& store) { return static_cast<SqlPriorStore&>(store); }

SqliteDatabase& DatabaseOf(priors::PriorStore& store) {
  return static_cast<SqliteDatabase&>(StoreOf(store).database());
}

std::unique_ptr<SqliteDatabase> Own(SqliteDatabase database) {
  return std::make_unique<SqliteDatabase>(std::move(database));
}

}  // namespace

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits, uint64_t max_bytes,
    OnSync on_sync) {
  auto database = OpenPriorDatabase(path);
  if (!database.ok()) return database.status();
  absl::Status status = database->SetPlace(path);
  if (status.ok() && max_bytes > 0) status = database->LimitSize(max_bytes);
  if (status.ok() && on_sync) status = database->TimeSyncs(std::move(on_sync));
  if (!status.ok()) return status;
  return std::make_unique<SqlPriorStore>(Own(*std::move(database)), audit_limits);
}

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenMemoryPriorStore(
    const priors::AuditLimits& audit_limits) {
  auto database = OpenPriorDatabaseInMemory();
  if (!database.ok()) return database.status();
  return std::make_unique<SqlPriorStore>(Own(*std::move(database)), audit_limits);
}

absl::StatusOr<std::unique_ptr<ReadConnection>> OpenSqliteReadConnection(
    const std::filesystem::path& path) {
  auto database = OpenPriorDatabaseToRead(path);
  if (!database.ok()) return database.status();
  return MakeReadConnection(Own(*std::move(database)));
}

absl::StatusOr<uint64_t> CountCommits(priors::PriorStore& store) {
  return StoreOf(store).CountCommits();
}

absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes) {
  absl::Status status;
  if (!StoreOf(store).database().shared()) status = DatabaseOf(store).LimitSize(max_bytes);
  StoreOf(store).Limit(audit_limits);
  return status;
}

absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store) {
  return DatabaseOf(store).UsedBytes();
}

absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit) {
  SqliteDatabase& database = DatabaseOf(store);
  // Ignores the error that a running read causes. The copy includes the content of the write-ahead
  // log in any case.
  database.Execute("PRAGMA wal_checkpoint(TRUNCATE)").IgnoreError();
  return database.CopyTo(file.string(), edit);
}

}  // namespace sweepstake::storage
