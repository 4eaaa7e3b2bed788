// The prior store in PostgreSQL, which several daemons can share. Used by one thread at a time.
//
// It needs a server of version 15 or later and a UTF-8 database, in which it makes its tables in a
// schema named "sweepstake".
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

// Makes the tables (sql/sql_schema.h) if they are missing, once even if several daemons start
// together. Returns the random id of the tables, which distinguishes them from the tables of
// another database. Errors: those of the connection, FAILED_PRECONDITION (the tables have another
// schema version, or the database does not store text as UTF-8). REQUIRES: the connection is
// connected, and in no transaction.
absl::StatusOr<std::string> PreparePostgresSchema(SqlDatabase& connection);

// Opens the store of a postgresql:// URL or a conninfo string of libpq. Errors: UNAVAILABLE,
// FAILED_PRECONDITION (see PreparePostgresSchema).
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenPostgresPriorStore(
    const std::string& url, const priors::AuditLimits& audit_limits = {});

// Opens a connection for a ReadThread. If the server does not answer, reads return UNAVAILABLE.
std::unique_ptr<ReadConnection> OpenPostgresReadConnection(const std::string& url);

}  // namespace sweepstake::storage
