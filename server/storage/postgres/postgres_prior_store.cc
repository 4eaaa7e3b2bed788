#include "server/storage/postgres/postgres_prior_store.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/sql/sql_prior_reader.h"
#include "server/storage/sql/sql_prior_store.h"
#include "server/storage/sql/sql_schema.h"

namespace sweepstake::storage {
namespace {

// Commits join a few hundred given rows with a table by its key. Without statistics about the
// table, the planner would choose a hash or merge join, which reads the whole table.
constexpr const char* kPlans =
    "SET enable_hashjoin = off; SET enable_mergejoin = off; SET jit = off";

// A lock until the end of the transaction, so that two daemons do not create the tables at the same
// time. The number is arbitrary.
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(7743300015)";

absl::Status MakeTables(SqlDatabase& connection) {
  absl::Status status = connection.Run(kLock);
  if (status.ok())
    status = connection.Execute(
        "CREATE SCHEMA IF NOT EXISTS sweepstake; "
        "CREATE TABLE IF NOT EXISTS sweepstake.schema_version (version bigint NOT NULL)");
  if (!status.ok()) return status;
  const auto version =
      connection.ReadInteger("SELECT coalesce(max(version), 0) FROM schema_version");
  if (!version.ok()) return version.status();
  if (*version == 0) {
    status = connection.Execute(PostgresSchema());
    if (!status.ok()) return status;
    return connection.Run("INSERT INTO schema_version VALUES (?1)", kSchemaVersion);
  }
  if (*version == kSchemaVersion) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("the tables in PostgreSQL have schema version ", *version,
                   ", but this daemon reads only version ", kSchemaVersion,
                   "; use the version of the daemon that created them, or another database"));
}

}  // namespace

absl::StatusOr<std::string> PreparePostgresSchema(SqlDatabase& connection) {
  const auto encoding = connection.ReadText("SELECT current_setting('server_encoding')");
  if (!encoding.ok()) return encoding;
  if (*encoding != "UTF8") {
    return absl::FailedPreconditionError(absl::StrCat(
        "the database stores text as ", *encoding,
        ", but must use UTF8; create one with `createdb --encoding=UTF8 --template=template0`"));
  }
  absl::Status status = InTransaction(connection, [&] { return MakeTables(connection); });
  if (!status.ok()) return status;
  return connection.ReadText("SELECT id FROM store");
}

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
