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

}  // namespace sweepstake::storage
