// The sources in PostgreSQL, locked and changed within the transaction of whoever calls.
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

// A source, and what is known of one that is new.
struct NewSource {
  std::string name;
  std::string build = {};
  uint64_t last_seen_unix_s = 0;
};

// A source that nobody else can change until the transaction ends.
struct LockedSource {
  int64_t id = 0;
  bool is_session = false;
  bool revoked = false;
  uint64_t commit_sequence = 0;
  uint64_t writer = 0;
  // Those of the transaction that apply; null if there is none.
  const priors::SourceUpdate* first = nullptr;
  const priors::SourceUpdate* last = nullptr;

  bool takes_imports() const { return !is_session && !revoked; }
  // Takes the update, which must outlive it. Returns false if it was applied before, or the source
  // is revoked. Error: FAILED_PRECONDITION (PriorStore::Commit says when).
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

  // Locks the sources in the order of their names. New ones are added, with numbers in the order
  // in which they are given; names may be given several times. Error: ABORTED (another daemon adds
  // one of them at the same time).
  absl::StatusOr<LockedSources> LockOrAdd(std::span<const NewSource> sources);
  // Writes what the sources have taken.
  absl::Status Update(const LockedSources& sources);
  // Locks those that match and are not revoked or, with `quarantined`, those of which something
  // waits: where they are revoked it is another project's, which that has left alone.
  absl::StatusOr<MatchingSources> LockMatching(const priors::SourceFilter& filter,
                                               bool quarantined);
  // Revokes the sources with these ids.
  absl::Status Bar(const PostgresArray& ids);

 private:
  absl::Status Lock(const LockedSources& names, LockedSources& found);
  // `sources` are those that there are not, each once.
  absl::Status Add(std::span<const NewSource* const> sources, LockedSources& found);

  PostgresConnection& connection_;
};

}  // namespace sweepstake::storage
