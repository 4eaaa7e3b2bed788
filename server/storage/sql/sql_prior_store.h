// The prior store, over a SQL database. Used by one thread at a time.
//
// Each call of Commit is one transaction, for any number of updates. In a shared database a
// transaction that conflicts with another daemon is repeated. If the connection is lost during a
// commit, its updates may be stored or not. Committing them again is safe, because stored updates
// are ignored (PriorStore::Commit). Rows are locked in this order, so that daemons do not deadlock:
// sources by name, keys by id, scenes by id, parties of the locked scenes.
//
// A commit adds its increments to the stored sums of its evidence keys. Import, Promote and Revoke
// compute the sums of the changed keys again, from one row of evidence per source.
#pragma once

#include <atomic>
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

  // Returns the sum of the numbers of the sources' latest commits. Only the first call reads the
  // sources. REQUIRES: the database is not shared.
  absl::StatusOr<uint64_t> CountCommits();

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override;
  absl::Status CheckPlace() override { return database_->CheckPlace(); }
  priors::StoreLosses losses() const override { return losses_; }
  absl::StatusOr<std::vector<priors::SceneKey>> TakeChangedScenes() override;
  void StopChangesWhen(const std::atomic<bool>& flag) override { stop_changes_ = &flag; }
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
    uint64_t writer = 0;  // SourceWriter::id of its last commit; 0 in SQLite
    // First and last update of this source that the transaction applies, or null.
    const priors::SourceUpdate* first = nullptr;
    const priors::SourceUpdate* last = nullptr;
  };
  using Sources = std::map<std::string, Source>;  // by name
  // The name of a source, and the values with which it is added if it is not stored yet.
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
  using RowList = std::vector<std::pair<Place, Row>>;  // can contain a place several times
  using Sequences = std::map<Place, uint64_t>;
  using Ids = std::set<int64_t>;
  // The players that add scenes in the running transaction.
  using Adders = std::map<priors::SceneKey, priors::SourceOrigin::Owner>;
  // What players add in the running transaction.
  struct PlayerAdditions {
    Adders adders;
    // Scenes that the party may not add.
    std::set<std::pair<priors::SceneKey, priors::SourceOrigin::Owner>> refused;
    // The regimes of each scene on all machine classes, with those that players add. The keys have
    // no machine class.
    std::map<priors::SceneKey, std::set<std::string>> regimes;
  };
  using SourceCounts = std::map<int64_t, int64_t>;  // change of the number of sources, by scene id
  struct KeyHash {
    size_t operator()(const priors::EvidenceKey& key) const {
      return absl::HashOf(key.project, key.scene, key.measured_by, key.arm, key.backend_version,
                          key.machine_class, key.reward_version, key.regime);
    }
  };
  // A row of evidence_key, and the id of its scene.
  struct StoredKey {
    int64_t id = 0;  // 0: unknown
    int64_t scene = 0;
    bool is_known = false;  // the column of evidence_key
  };
  using Keys = absl::flat_hash_map<priors::EvidenceKey, StoredKey, KeyHash>;
  using SceneCounts = std::map<std::string, priors::SceneCount>;  // by project
  // Runs `body` in a transaction. Rolls back if `body` fails. Repeats the transaction after a
  // conflict with another daemon.
  template <typename Body>
  absl::Status InTransaction(Body body);
  template <typename Body>
  absl::Status TryTransaction(Body& body);
  // Runs `change` in a transaction and returns its result. With a preview, passes the changed state
  // to the preview and then rolls back.
  template <typename Result, typename Change>
  absl::StatusOr<Result> ChangeUnless(const priors::Preview& preview, Change change);
  // Clears known_keys_ and changes_since_ if the connection was opened again, because the server
  // may have been restored from a backup.
  void CheckIncarnation();

  // Commits the updates, and writes their audit rows if `with_audit` is set. Sets what was not
  // stored in `lost`; without `with_audit`, the number of audit rows stays.
  absl::Status CommitAll(std::span<const priors::SourceUpdate> updates, bool with_audit,
                         priors::StoreLosses& lost);
  // Records in `source` that the transaction applies the update, which must outlive `source`.
  // Returns false if the update was applied before or the source is revoked. Error:
  // FAILED_PRECONDITION (see PriorStore::Commit).
  absl::StatusOr<bool> Advance(Source& source, const priors::SourceUpdate& update) const;
  // Adds the evidence to the stored rows of evidence, and to the sums of their keys.
  absl::Status AddEvidence(const Rows& rows);

  // LockOrAdd locks the sources in the order of their names. AddSources adds the missing ones, with
  // ids that grow in the order given. A name can be given several times. Error: ABORTED (another
  // daemon adds one of them at the same time).
  absl::StatusOr<Sources> LockOrAdd(std::span<const NewSource> sources);
  absl::Status AddSources(std::span<const NewSource* const> sources, Sources& found);
  // Writes the progress of the applied updates to the table of sources.
  absl::Status UpdateSources(const Sources& sources);
  // Locks the matching sources and returns their ids. If `quarantined`, matches sources with
  // evidence in quarantine, even revoked ones (a revocation for one project keeps the quarantined
  // evidence about other projects); otherwise matches sources that are not revoked.
  absl::StatusOr<Ids> LockMatching(const priors::SourceFilter& filter, bool quarantined);
  absl::Status Bar(const Ids& sources);

  // Returns whether the player of the update may add evidence with this key. Notes what that adds.
  absl::StatusOr<bool> MayAdd(const priors::SourceUpdate& update, const priors::EvidenceKey& key,
                              PlayerAdditions& additions);
  // Returns whether players may add evidence about the regime of this key. Notes the regime.
  absl::StatusOr<bool> MayAddRegime(const priors::EvidenceKey& key, PlayerAdditions& additions);
  // Returns the stored keys in the order of `keys`. Adds the missing ones, with `adders` for their
  // scenes.
  absl::StatusOr<std::vector<StoredKey>> FindOrAddKeys(
      std::span<const priors::EvidenceKey* const> keys, const Adders& adders = {});
  // Makes the arms of the keys known. `stored` has the rows of `keys`.
  absl::Status MakeKnown(std::span<const priors::EvidenceKey* const> keys,
                         std::span<const StoredKey> stored);
  absl::Status MakeKnown(const Ids& keys, const Ids& scenes);
  // Looks the keys up in the database. Moves the keys that it finds from `unknown` to `new_keys_`.
  absl::Status FindKeys(std::set<priors::EvidenceKey>& unknown);

  // Converts the records to rows. Omits records of sessions and of revoked sources, which accept no
  // imports, and counts them in `result`.
  absl::StatusOr<RowList> RowsOf(std::span<const priors::PriorRecord> records,
                                 priors::ImportResult& result);
  absl::StatusOr<priors::ImportResult> ImportAll(std::span<const priors::PriorRecord> records);
  absl::StatusOr<priors::ImportResult> QuarantineAll(std::span<const priors::PriorRecord> records,
                                                     uint64_t max_records);
  absl::StatusOr<priors::ChangeResult> PromoteAll(const priors::SourceFilter& filter);
  absl::StatusOr<priors::ChangeResult> RevokeAll(const priors::SourceFilter& filter);
  // Returns the sequence numbers of the rows at these places: of the evidence in use or, if
  // `quarantined`, in quarantine.
  absl::StatusOr<Sequences> LoadSequences(const std::set<Place>& places, bool quarantined);
  // For each place, stores the newest of `rows` if it is newer than the stored row. Writes to the
  // evidence in use or, if `quarantined`, to the quarantine. Counts applied and unchanged rows in
  // `result`.
  absl::Status Replace(const Sequences& stored, const RowList& rows, bool quarantined,
                       priors::ImportResult& result);
  // Deletes the quarantined rows of the sources about a project (empty: about all projects) and
  // returns them. Includes damaged rows only if `with_damaged`.
  absl::StatusOr<RowList> TakeOut(const Ids& sources, const std::string& project,
                                  bool with_damaged);
  // Computes the sums of the keys from their rows.
  absl::Status RecountSums(const Ids& keys);
  // Records which source has evidence about which scene. Adds 1 to the scene's count in `scenes`
  // for each pair that is new.
  absl::Status JoinScenes(const std::set<std::pair<int64_t, int64_t>>& sources_and_scenes,
                          SourceCounts& scenes);
  // The opposite: removes the sources of the batch (id, project) from their scenes, and subtracts 1
  // from the scene's count in `scenes` for each.
  absl::Status LeaveScenes(const SqlBatch& sources, SourceCounts& scenes);
  // Adds the changes to the source counts of the scenes. In a shared database also marks the scenes
  // as changed by this transaction.
  absl::Status ChangeScenes(const SourceCounts& changes);

  const std::unique_ptr<SqlDatabase> database_;
  SqlAuditLog audit_;
  const std::atomic<bool>* stop_changes_ = nullptr;
  uint64_t incarnation_ = 0;   // SqlDatabase::incarnation when known_keys_ were read
  std::string changes_since_;  // transaction id from which TakeChangedScenes reads next
  Keys known_keys_;            // committed; keys are never deleted
  Keys new_keys_;              // found or added by the running transaction
  // Results of CountScenes by project, cached for projects with scenes. Empty in a shared database.
  SceneCounts scene_counts_;
  SceneCounts added_counts_;              // changes of scene_counts_ by the running transaction
  std::optional<uint64_t> commit_count_;  // the result of CountCommits
  uint64_t added_commits_ = 0;            // by the running transaction
  priors::StoreLosses losses_;
};

}  // namespace sweepstake::storage
