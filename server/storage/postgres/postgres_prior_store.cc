#include "server/storage/postgres/postgres_prior_store.h"

#include <utility>

#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_schema.h"
#include "server/storage/sql/sql_prior_reader.h"
#include "server/storage/sql/sql_prior_store.h"

namespace sweepstake::storage {
namespace {

// Commits join a few hundred given rows with tables by their keys. Without statistics about a table
// the server would read all of it.
constexpr const char* kPlans =
    "SET enable_hashjoin = off; SET enable_mergejoin = off; SET jit = off";
constexpr const char* kShareResumeKey =
    "UPDATE store SET resume_key = coalesce(resume_key, ?1) RETURNING resume_key";

}  // namespace

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenPostgresPriorStore(
    const std::string& url, const priors::AuditLimits& audit_limits) {
  auto connection = std::make_unique<PostgresConnection>(url, kPlans);
  if (absl::Status status = connection->Connect(); !status.ok()) return status;
  auto id = PreparePostgresSchema(*connection);
  if (!id.ok()) return id.status();
  connection->Expect(*std::move(id));
  return std::make_unique<SqlPriorStore>(std::move(connection), audit_limits);
}

std::unique_ptr<ReadConnection> OpenPostgresReadConnection(const std::string& url) {
  return MakeReadConnection(std::make_unique<PostgresConnection>(url));
}

absl::StatusOr<std::string> ShareResumeKey(priors::PriorStore& store, const std::string& own) {
  SqlDatabase& database = static_cast<SqlPriorStore&>(store).database();
  SqlTransaction transaction(database);
  absl::Status status = transaction.begun();
  std::string key;
  if (status.ok())
    status = database.ForEachRow(
        kShareResumeKey, [&](const SqlRow& row) { key = row.Bytes(0); }, SqlBytes{own});
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) return status;
  return key;
}

void LimitPostgresAudit(priors::PriorStore& store, const priors::AuditLimits& audit_limits) {
  static_cast<SqlPriorStore&>(store).Limit(audit_limits);
}

}  // namespace sweepstake::storage
