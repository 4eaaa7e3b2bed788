#include "server/storage/postgres/postgres_schema.h"

#include "absl/strings/str_cat.h"
#include "server/storage/sql/sql_schema.h"

namespace sweepstake::storage {
namespace {

// Keeps two daemons from making the tables at the same time, until the transaction's end.
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(7743300015)";

absl::Status MakeTables(SqlDatabase& connection) {
  SqlTransaction transaction(connection);
  absl::Status status = transaction.begun();
  if (status.ok()) status = connection.Run(kLock);
  if (status.ok())
    status = connection.Execute(
        "CREATE SCHEMA IF NOT EXISTS sweepstake; "
        "CREATE TABLE IF NOT EXISTS sweepstake.schema_version (version bigint NOT NULL)");
  int64_t version = 0;
  if (status.ok())
    status = connection.ForEachRow("SELECT coalesce(max(version), 0) FROM schema_version",
                                   [&](const SqlRow& row) { version = row.Integer(0); });
  if (!status.ok()) return status;
  if (version == 0) {
    status = connection.Execute(PostgresSchema());
    if (status.ok())
      status = connection.Run("INSERT INTO schema_version VALUES (?1)", kSchemaVersion);
  } else if (version != kSchemaVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat("the tables in PostgreSQL have schema version ", version,
                     ", and this daemon reads version ", kSchemaVersion,
                     " alone; use the daemon that made them, or another database"));
  }
  return status.ok() ? transaction.Commit() : status;
}

absl::StatusOr<std::string> TextOf(SqlDatabase& connection, const char* sql) {
  std::string text;
  absl::Status status = connection.ForEachRow(sql, [&](const SqlRow& row) { text = row.Text(0); });
  if (!status.ok()) return status;
  return text;
}

}  // namespace

absl::StatusOr<std::string> PreparePostgresSchema(SqlDatabase& connection) {
  const auto encoding = TextOf(connection, "SELECT current_setting('server_encoding')");
  if (!encoding.ok()) return encoding;
  if (*encoding != "UTF8") {
    return absl::FailedPreconditionError(
        absl::StrCat("the database keeps text as ", *encoding,
                     "; make one with `createdb --encoding=UTF8 --template=template0`"));
  }
  if (absl::Status status = MakeTables(connection); !status.ok()) return status;
  return PostgresStoreId(connection);
}

absl::StatusOr<std::string> PostgresStoreId(SqlDatabase& connection) {
  return TextOf(connection, "SELECT id FROM store");
}

}  // namespace sweepstake::storage
