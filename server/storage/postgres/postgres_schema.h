// The tables of the prior store in PostgreSQL, in a schema of their own named "sweepstake".
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/storage/postgres/postgres_connection.h"

namespace sweepstake::storage {

// Makes the tables if there are none, once where several daemons begin together, and returns the
// random id that they got then, by which they can be told from those of another database. Errors:
// those of the connection, FAILED_PRECONDITION (the tables have another schema version, or the
// database keeps text other than as UTF-8). REQUIRES: the connection is connected, and in no
// transaction.
absl::StatusOr<std::string> PreparePostgresSchema(PostgresConnection& connection);

// Returns that id. Errors: those of the connection (there are no tables: UNAVAILABLE).
absl::StatusOr<std::string> PostgresStoreId(PostgresConnection& connection);

}  // namespace sweepstake::storage
