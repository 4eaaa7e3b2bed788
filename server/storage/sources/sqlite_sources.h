// Which sources of the prior store on SQLite a filter means, and how they are revoked. Each of
// these runs in the store's transaction.
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

// Returns the ids and names of those that are not revoked or, with `quarantined`, of those of which
// something waits: where they are revoked it is another project's, which that has left alone.
absl::StatusOr<std::map<int64_t, std::string>> MatchingSources(PriorStatements& statements,
                                                               const priors::SourceFilter& filter,
                                                               bool quarantined);

// Adds the sums of the keys anew.
absl::Status RecountSums(PriorStatements& statements, const KeyIds& keys);

// Does what PriorStore::Revoke says.
absl::StatusOr<priors::RevokeResult> RevokeSources(PriorStatements& statements,
                                                   const priors::SourceFilter& filter);

// What a source taught about a key.
struct QuarantinedRow {
  int64_t source = 0;
  StoredKey key;
  uint64_t sequence = 0;
  priors::Evidence evidence;
};

// Returns false if what is in quarantine, or counts already, is as new.
absl::StatusOr<bool> SetAside(PriorStatements& statements, const QuarantinedRow& row);

// Error: RESOURCE_EXHAUSTED (there are more rows).
absl::Status CheckQuarantineSize(PriorStatements& statements, uint64_t max_rows);

// Returns the source's rows of the project, or of all if that is empty. A damaged one is left out.
absl::StatusOr<std::vector<QuarantinedRow>> QuarantinedOf(PriorStatements& statements,
                                                          int64_t source,
                                                          const std::string& project);

}  // namespace sweepstake::storage
