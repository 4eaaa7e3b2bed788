// The prior store in PostgreSQL, which many daemons share. Used by one thread at a time.
//
// It needs a server of version 15 or later and a UTF-8 database, in which it makes its tables in a
// schema named "sweepstake". If the server does not answer, each call returns UNAVAILABLE at once
// or after five seconds, and the next call connects again, but only to the same database as before.
//
// A commit is one transaction. Daemons add to the same rows in whole units, so that the sums are
// the same in any order. A transaction that conflicts with another daemon is repeated. A commit
// whose answer was lost may be stored; if it is offered again, it is ignored (PriorStore::Commit).
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

// Opens the store of a postgresql:// URL or a conninfo string of libpq. Errors: UNAVAILABLE,
// FAILED_PRECONDITION (PreparePostgresSchema says when).
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenPostgresPriorStore(
    const std::string& url, const priors::AuditLimits& audit_limits = {});

// Returns the key that signs the resume tokens of all daemons of the store, so that a session can
// continue at any of them. Stores and returns `own` if the store has no key yet. Errors:
// UNAVAILABLE. REQUIRES: `store` is of OpenPostgresPriorStore.
absl::StatusOr<std::string> ShareResumeKey(priors::PriorStore& store, const std::string& own);

// Changes the limits of the audit log. REQUIRES: `store` is of OpenPostgresPriorStore.
void LimitPostgresAudit(priors::PriorStore& store, const priors::AuditLimits& audit_limits);

}  // namespace sweepstake::storage
