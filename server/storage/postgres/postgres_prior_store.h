// The prior store in PostgreSQL, which many daemons share. Used by one thread at a time.
//
// It needs a server of version 15 or later and a database that keeps text as UTF-8, in which it
// makes its tables, in a schema named "sweepstake". Where the server does not answer, each call is
// UNAVAILABLE at once or after five seconds, and the next one connects anew; but not to another
// database than the one that was there before.
//
// A commit is one transaction, whatever the number of increments. What it and those of other
// daemons add to the same rows is added in whole units, and gives the same sums in every order.
// What another daemon was in the way of is tried again. A commit whose answer was lost may be
// there; offered again, it is ignored then, as it is said of PriorStore::Commit.
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
// go on at any: `own` where none has given one before. Errors: UNAVAILABLE. REQUIRES: `store` is of
// OpenPostgresPriorStore.
absl::StatusOr<std::string> ShareResumeKey(priors::PriorStore& store, const std::string& own);

// Changes the limits of the audit log. REQUIRES: `store` is of OpenPostgresPriorStore.
void LimitPostgresAudit(priors::PriorStore& store, const priors::AuditLimits& audit_limits);

}  // namespace sweepstake::storage
