// The sources in PostgreSQL, locked and changed in the transaction of the caller.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/postgres/postgres_connection.h"

namespace sweepstake::storage {

// A source that may be new, with its first values.
struct NewSource {
  std::string name;
  std::string build = {};
  uint64_t last_seen_unix_s = 0;
};

// A source that is locked until the transaction ends.
struct LockedSource {
  int64_t id = 0;
  bool is_session = false;
  bool revoked = false;
  uint64_t commit_sequence = 0;
  uint64_t writer = 0;
  // First and last applied update of the transaction, or null.
  const priors::SourceUpdate* first = nullptr;
  const priors::SourceUpdate* last = nullptr;

  bool takes_imports() const { return !is_session && !revoked; }
  // Applies the update, which must outlive this object. Returns false if it was applied before or
  // the source is revoked. Error: FAILED_PRECONDITION (see PriorStore::Commit).
  absl::StatusOr<bool> Advance(const priors::SourceUpdate& update);
};
using LockedSources = std::map<std::string, LockedSource>;  // by name

// The sources that match a filter.
struct MatchingSources {
  PostgresArray ids;
  uint64_t count = 0;
};

class PostgresSources {
 public:
  // `connection` must outlive it.
  explicit PostgresSources(PostgresConnection& connection) : connection_(connection) {}

  // Locks the sources in the order of their names. Adds the missing ones, numbered in the order
  // given. A name may be given several times. Error: ABORTED (another daemon adds one of them at
  // the same time).
  absl::StatusOr<LockedSources> LockOrAdd(std::span<const NewSource> sources);
  // Writes the applied updates.
  absl::Status Update(const LockedSources& sources);
  // Locks the matching sources that are not revoked. With `quarantined`, locks those with evidence
  // in quarantine instead: a revocation for one project leaves that of other projects there.
  absl::StatusOr<MatchingSources> LockMatching(const priors::SourceFilter& filter,
                                               bool quarantined);
  // Revokes the sources with these ids.
  absl::Status Bar(const PostgresArray& ids);

 private:
  absl::Status Lock(const LockedSources& names, LockedSources& found);
  // REQUIRES: the sources are missing, and each is given once.
  absl::Status Add(std::span<const NewSource* const> sources, LockedSources& found);

  PostgresConnection& connection_;
};

}  // namespace sweepstake::storage
