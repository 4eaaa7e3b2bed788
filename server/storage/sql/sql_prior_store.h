// The prior store, over a SQL database. Used by one thread at a time.
//
// A commit is one transaction, for any number of updates. In a shared database a transaction that
// conflicts with another daemon is repeated, and a commit whose answer was lost may be stored; if
// it is offered again, it is ignored (PriorStore::Commit). Rows are locked in this order, so that
// daemons do not deadlock: sources by name, keys by id, scenes by id.
//
// A commit adds to the sums of its keys. Import, Promote and Revoke compute the sums of the changed
// keys from one row per source.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/hash/hash.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sql/sql_audit_log.h"
#include "server/storage/sql/sql_database.h"
#include "server/storage/sql/sql_prior_reader.h"

namespace sweepstake::storage {

class SqlPriorStore final : public priors::PriorStore, private SqlPriorReader {
 public:
  SqlPriorStore(std::unique_ptr<SqlDatabase> database, const priors::AuditLimits& audit_limits);

  SqlDatabase& database() { return *database_; }
  // Changes the limits of the audit log, and removes rows beyond them. If the database cannot
  // remove them now, a later commit does.
  void Limit(const priors::AuditLimits& audit_limits);

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override;
  absl::Status CheckPlace() override { return database_->CheckPlace(); }
  uint64_t lost_audit_row_count() const override { return lost_audit_row_count_; }
  absl::StatusOr<std::vector<priors::SceneKey>> TakeChangedScenes() override;
  absl::StatusOr<priors::ImportResult> Import(
      std::span<const priors::PriorRecord> records) override;
  absl::StatusOr<priors::ImportResult> Quarantine(std::span<const priors::PriorRecord> records,
                                                  uint64_t max_records) override;
  absl::StatusOr<priors::ChangeResult> Promote(const priors::SourceFilter& filter,
                                               const priors::Preview& preview) override;
  absl::StatusOr<priors::ChangeResult> Revoke(const priors::SourceFilter& filter,
                                              const priors::Preview& preview) override;
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override;

 private:
  // A source that is locked until the transaction ends.
  struct Source {
    int64_t id = 0;
    bool is_session = false;
    bool revoked = false;
    uint64_t commit_sequence = 0;
    uint64_t writer = 0;  // known in a shared database only
    // First and last applied update of the transaction, or null.
    const priors::SourceUpdate* first = nullptr;
    const priors::SourceUpdate* last = nullptr;
  };
  using Sources = std::map<std::string, Source>;  // by name
  // A source that may be new, with its first values.
  struct NewSource {
    std::string name;
    std::string build = {};
    uint64_t last_seen_unix_s = 0;
  };
  // The evidence of one source about one key.
  struct Row {
    uint64_t sequence = 0;
    priors::Evidence evidence;
    int64_t scene = 0;  // the id of the key's scene
  };
  using Place = std::pair<int64_t, int64_t>;  // the ids of the key and the source
  using Rows = std::map<Place, Row>;
  using RowList = std::vector<std::pair<Place, Row>>;  // maybe several for one place
  using Sequences = std::map<Place, uint64_t>;
  using Ids = std::set<int64_t>;
  using SourceCounts = std::map<int64_t, int64_t>;  // how many sources each scene gains
  struct KeyHash {
    size_t operator()(const priors::EvidenceKey& key) const {
      return absl::HashOf(key.project, key.scene, key.measured_by, key.arm, key.backend_version,
                          key.machine_class, key.reward_version);
    }
  };
  // The ids of a key and of its scene.
  struct StoredKey {
    int64_t id = 0;  // 0: unknown
    int64_t scene = 0;
  };
  using Keys = absl::flat_hash_map<priors::EvidenceKey, StoredKey, KeyHash>;
  using SceneCounts = std::map<std::string, priors::SceneCount>;  // by project
  // Runs `body` in a transaction, which is rolled back if it fails, and repeats it after a conflict
  // with another daemon.
  template <typename Body>
  absl::Status InTransaction(Body body);
  template <typename Body>
  absl::Status TryTransaction(Body& body);
  // Runs `change`, which returns a result, in a transaction. A preview is rolled back.
  template <typename Result, typename Change>
  absl::StatusOr<Result> ChangeUnless(const priors::Preview& preview, Change change);
  // Forgets what it knows of a database after the connection to it was lost.
  void CheckIncarnation();

  // Commits the updates. Adds to `lost` the audit rows that were not written; writes none if it is
  // null.
  absl::Status CommitAll(std::span<const priors::SourceUpdate> updates, uint64_t* lost);
  // Applies the update, which must outlive the source. Returns false if it was applied before or
  // the source is revoked. Error: FAILED_PRECONDITION (see PriorStore::Commit).
  absl::StatusOr<bool> Advance(Source& source, const priors::SourceUpdate& update) const;
  // Adds the evidence to the stored rows, and to the sums.
  absl::Status AddEvidence(const Rows& rows);

  // Lock the sources in the order of their names, and add the missing ones, numbered in the order
  // given. A name may be given several times. Error: ABORTED (another daemon adds one of them at
  // the same time).
  absl::StatusOr<Sources> LockOrAdd(std::span<const NewSource> sources);
  absl::Status AddSources(std::span<const NewSource* const> sources, Sources& found);
  // Writes the applied updates.
  absl::Status UpdateSources(const Sources& sources);
  // Locks the matching sources that are not revoked. With `quarantined`, locks those with evidence
  // in quarantine instead: a revocation for one project leaves that of other projects there.
  absl::StatusOr<Ids> LockMatching(const priors::SourceFilter& filter, bool quarantined);
  absl::Status Bar(const Ids& sources);

  // Returns the keys in the order given. Missing keys are added.
  absl::StatusOr<std::vector<StoredKey>> FindOrAddKeys(
      std::span<const priors::EvidenceKey* const> keys);
  // Moves the keys that are found from `unknown` to `new_keys_`.
  absl::Status FindKeys(std::set<priors::EvidenceKey>& unknown);

  // Returns the records of sources that take imports as rows. Counts the others.
  absl::StatusOr<RowList> RowsOf(std::span<const priors::PriorRecord> records,
                                 priors::ImportResult& result);
  absl::StatusOr<priors::ImportResult> ImportAll(std::span<const priors::PriorRecord> records);
  absl::StatusOr<priors::ImportResult> QuarantineAll(std::span<const priors::PriorRecord> records,
                                                     uint64_t max_records);
  absl::StatusOr<priors::ChangeResult> PromoteAll(const priors::SourceFilter& filter);
  absl::StatusOr<priors::ChangeResult> RevokeAll(const priors::SourceFilter& filter);
  // Returns the sequences of the stored rows, or of those in quarantine.
  absl::StatusOr<Sequences> LoadSequences(const std::set<Place>& places, bool quarantined);
  // Stores the newest given row of each place that is newer than the stored one, as evidence that
  // counts or in quarantine.
  absl::Status Replace(const Sequences& stored, const RowList& rows, bool quarantined,
                       priors::ImportResult& result);
  // Takes out the quarantined rows of the sources about a project, or about all projects if that is
  // empty. Leaves damaged rows there, or removes them too.
  absl::StatusOr<RowList> TakeOut(const Ids& sources, const std::string& project,
                                  bool with_damaged);
  // Computes the sums of the keys from their rows.
  absl::Status RecountSums(const Ids& keys);
  // Counts each source in the row's scene, once.
  absl::Status JoinScenes(const std::set<std::pair<int64_t, int64_t>>& sources_and_scenes,
                          SourceCounts& scenes);
  // Adds the numbers, and marks the scenes of a shared database as changed by this transaction.
  absl::Status ChangeScenes(const SourceCounts& changes);

  const std::unique_ptr<SqlDatabase> database_;
  SqlAuditLog audit_;
  uint64_t incarnation_ = 0;   // of the database whose keys are known
  std::string changes_since_;  // the first transaction that TakeChangedScenes reads
  Keys known_keys_;            // committed; keys are never deleted
  Keys new_keys_;              // found or added by the running transaction
  // Counts by project that were asked for, if the project has scenes. Each is read once. Empty in a
  // shared database.
  SceneCounts scene_counts_;
  SceneCounts added_counts_;  // by the running transaction
  uint64_t lost_audit_row_count_ = 0;
};

}  // namespace sweepstake::storage
