// The prior store in PostgreSQL, which many daemons share. Used by one thread at a time.
//
// It needs a server of version 15 or later and a UTF-8 database, in which it makes its tables in a
// schema named "sweepstake".
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"

namespace sweepstake::storage {

// Opens the store of a postgresql:// URL or a conninfo string of libpq. Errors: UNAVAILABLE,
// FAILED_PRECONDITION (PreparePostgresSchema says when).
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenPostgresPriorStore(
    const std::string& url, const priors::AuditLimits& audit_limits = {});

// Opens a connection for a ReadThread. If the server does not answer, reads return UNAVAILABLE.
std::unique_ptr<ReadConnection> OpenPostgresReadConnection(const std::string& url);

// Returns the key that signs the resume tokens of all daemons of the store, so that a session can
// continue at any of them. Stores and returns `own` if the store has no key yet. Errors:
// UNAVAILABLE. REQUIRES: `store` is of OpenPostgresPriorStore.
absl::StatusOr<std::string> ShareResumeKey(priors::PriorStore& store, const std::string& own);

// Changes the limits of the audit log. REQUIRES: `store` is of OpenPostgresPriorStore.
void LimitPostgresAudit(priors::PriorStore& store, const priors::AuditLimits& audit_limits);

}  // namespace sweepstake::storage
