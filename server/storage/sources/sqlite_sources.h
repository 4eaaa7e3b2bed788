// Selects and revokes sources of the prior store on SQLite, and moves evidence into and out of the
// quarantine. All of it runs in the store's transaction.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_prior_reader.h"
#include "server/storage/sqlite_prior_statements.h"

namespace sweepstake::storage {

using KeyIds = std::unordered_set<int64_t>;

// Returns the ids and names of the matching sources that are not revoked. With `quarantined`,
// returns those with evidence in quarantine instead: a revocation for one project leaves that of
// other projects there.
absl::StatusOr<std::map<int64_t, std::string>> MatchingSources(PriorStatements& statements,
                                                               const priors::SourceFilter& filter,
                                                               bool quarantined);

// Computes the sums of the keys from their rows.
absl::Status RecountSums(PriorStatements& statements, const KeyIds& keys);

// Implements PriorStore::Revoke.
absl::StatusOr<priors::RevokeResult> RevokeSources(PriorStatements& statements,
                                                   const priors::SourceFilter& filter);

// A source's evidence about a key.
struct QuarantinedRow {
  int64_t source = 0;
  StoredKey key;
  uint64_t sequence = 0;
  priors::Evidence evidence;
};

// Returns false if the stored evidence, in quarantine or not, is at least as new.
absl::StatusOr<bool> SetAside(PriorStatements& statements, const QuarantinedRow& row);

// Error: RESOURCE_EXHAUSTED (more than `max_rows` wait).
absl::Status CheckQuarantineSize(PriorStatements& statements, uint64_t max_rows);

// Returns the source's rows of the project, or of all if that is empty, without damaged ones.
absl::StatusOr<std::vector<QuarantinedRow>> QuarantinedOf(PriorStatements& statements,
                                                          int64_t source,
                                                          const std::string& project);

}  // namespace sweepstake::storage
