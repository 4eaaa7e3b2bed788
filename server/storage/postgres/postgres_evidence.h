// The rows of evidence in PostgreSQL, and the sums and counts over them, changed in the transaction
// of the caller.
//
// Amounts are added in whole units, so that sums are the same to the bit in any order. Rows are
// locked in this order, so that daemons do not deadlock: sources by name (by the caller), keys by
// id, scenes by id.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/hash/hash.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/postgres/postgres_connection.h"

namespace sweepstake::storage {

// An amount of evidence that is added, or subtracted if it is negative.
struct EvidenceUnits {
  Units alpha = 0;
  Units beta = 0;
  Units window_count = 0;
  Units bail_out_count = 0;

  EvidenceUnits& operator+=(const EvidenceUnits& other);
  EvidenceUnits& operator-=(const EvidenceUnits& other);
};
EvidenceUnits UnitsOf(const priors::Evidence& evidence);
// Reads the columns alpha, beta, window_count and bail_out_count, from column `first` on.
EvidenceUnits UnitsOf(const PostgresRow& row, int first);

// The same columns, as parameters.
struct UnitArrays {
  PostgresArray alpha, beta, window_count, bail_out_count;

  void Add(const EvidenceUnits& units);
};

// The change of one source's row about one key.
struct RowChange {
  uint64_t sequence = 0;  // of the source, after the change
  EvidenceUnits units;
};
using RowPlace = std::pair<int64_t, int64_t>;  // the ids of the key and the source
using RowChanges = std::map<RowPlace, RowChange>;

// The removed evidence of sources.
struct RemovedEvidence {
  uint64_t record_count = 0;
  uint64_t window_count = 0;
};

class PostgresEvidence {
 public:
  // `connection` must outlive it.
  explicit PostgresEvidence(PostgresConnection& connection) : connection_(connection) {}

  // Returns the ids of the keys, in the order given. Missing keys are added.
  absl::StatusOr<std::vector<int64_t>> FindOrAddKeys(
      std::span<const priors::EvidenceKey* const> keys);
  // Returns the stored rows, with their sequences. Missing rows are left out.
  absl::StatusOr<RowChanges> Load(const std::set<RowPlace>& places);
  // REQUIRES: the sources are locked.
  absl::Status Apply(const RowChanges& changes);
  // Removes the evidence of the sources about a project, or all if that is empty. REQUIRES: the
  // sources are locked.
  absl::StatusOr<RemovedEvidence> Remove(const PostgresArray& sources, const std::string& project);
  // Ends a transaction. If it was committed, the keys that it added exist.
  void OnEnd(bool committed);
  // Forgets the known keys: a new connection may be to a server that has lost some.
  void OnReconnected() { known_keys_.clear(); }

 private:
  struct KeyChange {
    EvidenceUnits units;
    int64_t source_count = 0;
  };
  struct KeyHash {
    size_t operator()(const priors::EvidenceKey& key) const {
      return absl::HashOf(key.project, key.scene, key.measured_by, key.arm, key.backend_version,
                          key.machine_class, key.reward_version);
    }
  };
  using KeyIds = absl::flat_hash_map<priors::EvidenceKey, int64_t, KeyHash>;

  // Puts their ids into `new_keys_`.
  absl::Status AddKeys(const std::set<priors::EvidenceKey>& keys);
  // How many sources each scene gains, by the ids of the scenes.
  using SceneChanges = std::map<int64_t, int64_t>;
  // Also inserts the keys' scenes into `scenes`.
  absl::Status AddToSums(const std::map<int64_t, KeyChange>& changes, SceneChanges& scenes);
  // Adds the numbers, and marks the scenes as changed by this transaction.
  absl::Status ChangeScenes(const SceneChanges& changes);

  PostgresConnection& connection_;
  KeyIds known_keys_;  // committed, so that they stay
  KeyIds new_keys_;    // found or added by the running transaction
};

}  // namespace sweepstake::storage
