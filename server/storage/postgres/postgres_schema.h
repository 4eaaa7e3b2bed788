// Makes the tables of the prior store (sql/sql_schema.h) in PostgreSQL, in a schema named
// "sweepstake".
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

// Makes the tables if they are missing, once even if several daemons start together. Returns the
// random id of the tables, which tells them from those of another database. Errors: those of the
// connection, FAILED_PRECONDITION (the tables have another schema version, or the database does not
// store text as UTF-8). REQUIRES: the connection is connected, and in no transaction.
absl::StatusOr<std::string> PreparePostgresSchema(SqlDatabase& connection);

// Returns that id. Errors: those of the connection (UNAVAILABLE if the tables are missing).
absl::StatusOr<std::string> PostgresStoreId(SqlDatabase& connection);

}  // namespace sweepstake::storage
