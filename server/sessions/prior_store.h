// The storage of learnt evidence. Evidence is stored as increments per source (session), so that a
// retry is never counted twice and a bad source can be removed. Readers get the sum over the
// sources.
//
// These are plain values and interfaces without I/O. One thread at a time may use a PriorReader or
// PriorStore, any thread an AsyncPriorStore. Strings are UTF-8; stores keep them as text and
// compare them byte by byte.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine_client/decider/pooling/prior_record.h"
#include "engine_client/decider/pooling/scene_pool.h"
#include "server/sessions/audit_rows.h"

namespace sweepstake::priors {

using sweepstake::Evidence;
using sweepstake::EvidenceKey;
using sweepstake::PriorRecord;

// Returns the evidence rounded to multiples of 2⁻²⁰, the unit in which stores keep it. Sums up to
// 2³³ are then exact in any order, so that subtracting evidence restores the sum from before it was
// added.
inline Evidence InUnits(Evidence evidence) {
  constexpr double kUnitsPerOne = 0x1p20;
  evidence.alpha = std::round(evidence.alpha * kUnitsPerOne) / kUnitsPerOne;
  evidence.beta = std::round(evidence.beta * kUnitsPerOne) / kUnitsPerOne;
  return evidence;
}

struct KeyedEvidence {
  EvidenceKey key;
  Evidence evidence;

  friend bool operator==(const KeyedEvidence&, const KeyedEvidence&) = default;
};

// The progress of a source. All numbers except the seed are below 2^63.
struct SourceProgress {
  std::string source_id;
  uint64_t commit_sequence = 0;   // begins at 1 and grows with each commit of the source
  uint64_t message_sequence = 0;  // every client message up to this one is included
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
  // Frames in the messages up to message_sequence, including frames that gave no evidence.
  uint64_t frame_count = 0;
  uint64_t seed = 0;

  friend bool operator==(const SourceProgress&, const SourceProgress&) = default;
};

// The origin of a source, stored with the source's first update.
struct SourceOrigin {
  std::string build;         // build of the game; empty if unknown
  int64_t token_id = 0;      // token with which the session began; 0 for none
  std::string player = {};   // player that the session's ticket names; empty without a ticket
  std::string network = {};  // network of the client (net::NetworkOf); empty for the own machine

  // Returns who began the source, as far as it is known. The sources of a scene are divided evenly
  // among these parties. The ids of players have no '/', so they differ from all networks.
  const std::string& party() const { return player.empty() ? network : player; }
  // The token and the party; a default value for programs of the own machine without a token.
  using Owner = std::pair<int64_t, std::string>;
  Owner owner() const { return {token_id, party()}; }

  friend bool operator==(const SourceOrigin&, const SourceOrigin&) = default;
};

// The writer of a source: one run of its session in one daemon. A session that continues in another
// daemon, or that is read from the store again, is another writer.
struct SourceWriter {
  uint64_t id = 0;  // random; 0 for a source that only one daemon writes
  // Number of the source's last commit when this writer began; 0: none.
  uint64_t resumed_sequence = 0;
};

// One atomic update of one source: new evidence, and the progress that includes it.
struct SourceUpdate {
  SourceProgress progress;
  uint64_t unix_time_s = 0;               // wall-clock time of the update, below 2^63
  std::vector<KeyedEvidence> increments;  // may be empty; a key occurs at most once
  AuditRows audit;
  SourceOrigin origin = {};
  SourceWriter writer = {};
  // Keys whose scene and arm become known (PriorReader::LoadKnownArms). They are stored without
  // evidence.
  std::vector<EvidenceKey> known = {};
  // Whether the source is a player's. The party of such sources may add at most
  // kMaxScenesOfParty machine classes and reward versions to a scene; increments beyond them are
  // not stored. Such sources may add regimes to a scene that has fewer than kMaxRegimesOfPlayers;
  // further evidence is stored without its regime.
  bool is_of_player = false;
};

inline constexpr uint64_t kMaxScenesOfParty = 4;
// Half of the regimes of a scene (decision::kMaxStoredRegimes); the other places are the studio's.
inline constexpr size_t kMaxRegimesOfPlayers = 4;

// What successful commits did not store since the store was opened.
struct StoreLosses {
  uint64_t audit_row_count = 0;  // audit rows that could not be written
  // Increments of players that were not stored, or stored without their regime
  // (SourceUpdate::is_of_player).
  uint64_t player_increment_count = 0;
  std::string example = {};  // scene and party of the latest such increment
};

// Returns whether a commit failed because of an update that can never be stored: the update is
// invalid, or its source has another writer.
inline bool IsRefusal(const absl::Status& commit) {
  return absl::IsInvalidArgument(commit) || absl::IsFailedPrecondition(commit);
}

// The state of a source in a store.
struct SourceState {
  SourceProgress progress;
  std::vector<KeyedEvidence> evidence;  // ordered by key
  uint32_t audit_segment = 0;           // number of the latest stored audit segment, or 0
  // Times of the source's first and last commit to this store.
  uint64_t created_unix_s = 0;
  uint64_t last_seen_unix_s = 0;
};

// The key of a scene's posteriors. Keys are ordered by project, scene, machine class and reward
// version.
struct SceneKey {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 1;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SceneKey&, const SceneKey&) = default;
};

// Returns the key of an arm's evidence about a regime of the scene.
inline EvidenceKey EvidenceKeyOf(const SceneKey& scene, const std::string& arm,
                                 uint32_t backend_version, std::string_view measured_by,
                                 const std::string& regime = {}) {
  return {.project = scene.project,
          .scene = scene.scene,
          .measured_by = std::string(measured_by),
          .arm = arm,
          .backend_version = backend_version,
          .machine_class = scene.machine_class,
          .reward_version = scene.reward_version,
          .regime = regime};
}

// The evidence of every arm of one scene, summed over sources.
struct SceneEvidence {
  struct Measured {
    Evidence live;  // measured by the frame thread
    Evidence lane;  // measured by the shadow lane

    Evidence& of(std::string_view measured_by) { return measured_by.empty() ? live : lane; }
    const Evidence& of(std::string_view measured_by) const {
      return measured_by.empty() ? live : lane;
    }
    friend bool operator==(const Measured&, const Measured&) = default;
  };
  struct Arm {
    std::string name;
    uint32_t backend_version = 1;
    // The sums over all regimes.
    Evidence live;
    Evidence lane;
    // Time of the latest update by a source with evidence about this arm, even if that update was
    // about another arm. Only the latest kSourcesOfAge sources are considered. 0 if unknown.
    uint64_t last_seen_unix_s = 0;
    std::map<std::string, Measured> regimes = {};  // by bucket

    void Add(const std::string& regime, std::string_view measured_by, const Evidence& evidence) {
      (measured_by.empty() ? live : lane) += evidence;
      regimes[regime].of(measured_by) += evidence;
    }
    friend bool operator==(const Arm&, const Arm&) = default;
  };
  SceneKey key;
  std::vector<Arm> arms;  // ordered by name and version
  uint64_t source_count = 0;

  // Returns the arm; adds it if it is missing.
  Arm& ArmOf(const std::string& name, uint32_t backend_version);
};

inline SceneEvidence::Arm& SceneEvidence::ArmOf(const std::string& name, uint32_t backend_version) {
  const auto wanted = std::tie(name, backend_version);
  const auto arm =
      std::lower_bound(arms.begin(), arms.end(), wanted, [](const Arm& left, const auto& right) {
        return std::tie(left.name, left.backend_version) < right;
      });
  if (arm != arms.end() && std::tie(arm->name, arm->backend_version) == wanted) return *arm;
  return *arms.insert(arm,
                      {.name = name, .backend_version = backend_version, .live = {}, .lane = {}});
}

// Converts an arm's evidence, of one regime or of all, to the input of decision::PriorFor.
template <typename Measured>
decision::ArmEvidence EvidenceOf(const Measured& measured) {
  decision::ArmEvidence evidence = decision::EvidenceBy({}, measured.live);
  return evidence += decision::EvidenceBy(decision::kLaneName, measured.lane);
}

// Pools the arms' evidence. The result borrows their names.
inline decision::PooledScene Pool(std::span<const SceneEvidence::Arm> arms) {
  std::vector<decision::VersionEvidence> versions;
  for (const SceneEvidence::Arm& arm : arms)
    versions.push_back({arm.name, arm.backend_version, EvidenceOf(arm)});
  return decision::PoolScene(versions);
}

// Number of latest sources, per arm and kind of evidence (live, lane), that
// SceneEvidence::Arm::last_seen_unix_s considers.
inline constexpr uint32_t kSourcesOfAge = 8;

// The evidence of one source about one scene on one machine class.
struct SceneSource {
  std::string id;
  std::string build;              // empty if unknown
  uint64_t last_seen_unix_s = 0;  // 0 if unknown
  SceneEvidence evidence;         // evidence of this source only
};

// Selects scenes. An empty field matches everything.
struct SceneFilter {
  std::string project;
  std::string scene;
  // The project must be in this list, and also match `project`.
  std::vector<std::string> projects = {};

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SceneFilter&, const SceneFilter&) = default;
  bool Matches(std::string_view of_project, std::string_view of_scene) const {
    return (project.empty() || project == of_project) && (scene.empty() || scene == of_scene) &&
           (projects.empty() ||
            std::find(projects.begin(), projects.end(), of_project) != projects.end());
  }
};

// How many scenes of a project are stored.
struct SceneCount {
  uint64_t names = 0;
  uint64_t keys = 0;  // a name counts once per machine class and reward version
};

// A position in an export: directly after the record of this key and source. A default-constructed
// position is before all records.
struct ExportPlace {
  EvidenceKey key;
  uint64_t source_number = 0;  // assigned by the store, from 1; it never changes
};

struct ExportPage {
  std::vector<PriorRecord> records;
  ExportPlace next;  // position after the last record
};

struct ImportResult {
  uint64_t applied_count = 0;  // records that were new, or newer than the stored ones
  // Records that were stored, that belong to a session of this store, or whose source is revoked.
  uint64_t unchanged_count = 0;
};

// The prior of a new session uses at most this evidence of its scene: kSourcesOfScene sources of
// the session's machine class, and kSourcesOfOtherClasses sources of kOtherClasses other
// machine classes.
inline constexpr uint32_t kSourcesOfScene = 32;
inline constexpr uint32_t kSourcesOfOtherClasses = 32;
inline constexpr uint32_t kOtherClasses = 8;

// Selects sources; an unset field matches all.
struct SourceFilter {
  std::string id = {};
  // Sources with evidence of this project. Their evidence of other projects is not affected.
  std::string project = {};
  std::string build = {};
  int64_t token_id = 0;
  std::string player = {};
  std::string network = {};
  // Sources that began at this time or later; for an imported source, 0 counts as its start.
  uint64_t from_unix_s = 0;
  uint64_t until_unix_s = (1ull << 63) - 1;  // sources that began at this time or before

  friend bool operator==(const SourceFilter&, const SourceFilter&) = default;
};

// What a revocation or a promotion has changed.
struct ChangeResult {
  // Changed sources: newly revoked sources, or promoted ones that had records in quarantine.
  uint64_t source_count = 0;
  uint64_t record_count = 0;
  uint64_t window_count = 0;  // including lane visits
  // Only for a promotion: scenes whose evidence changes, one per machine class and reward version.
  uint64_t scene_count = 0;

  friend bool operator==(const ChangeResult&, const ChangeResult&) = default;
};

class PriorReader;

// Whether a change of the evidence is only previewed. A preview changes nothing; its `look` can
// read the store as it would be after the change. Converts implicitly from bool.
class Preview {
 public:
  using Look = std::function<void(PriorReader&)>;

  Preview(bool is_preview) : is_preview_(is_preview) {}  // NOLINT(google-explicit-constructor)
  // `look` runs again if the store has to repeat the transaction because of a conflict with another
  // writer.
  explicit Preview(Look look) : is_preview_(true), look_(std::move(look)) {}

  explicit operator bool() const { return is_preview_; }
  void Show(PriorReader& store) const {
    if (look_) look_(store);
  }

 private:
  bool is_preview_;
  Look look_;
};

// Reads a store. Only ExportQuarantined returns evidence in quarantine, which was imported but not
// promoted yet. Errors: UNAVAILABLE (the disk cannot be read, or the file is locked), DATA_LOSS
// (the requested rows are damaged).
class PriorReader {
 public:
  virtual ~PriorReader() = default;

  // Returns evidence about the scene, with the key's reward version. For each arm it is that of at
  // most kSourcesOfScene sources of the scene's class. In addition, it is that of
  // kSourcesOfOtherClasses sources of kOtherClasses other classes, preferably those with known
  // arms. decision::ChooseSources chooses them among the latest sources of the parties that were
  // active last, and divides the places evenly among tokens and parties. The cost does not depend
  // on the number of stored sources.
  virtual absl::StatusOr<std::vector<SceneSource>> LoadSources(const SceneKey& scene) = 0;

  // Returns the state of a source, or nothing if the source was never committed here (an imported
  // source is not a session of this store) or is revoked.
  virtual absl::StatusOr<std::optional<SourceState>> LoadSource(const std::string& source_id) = 0;

  // Returns up to `limit` scenes after `after` (exclusive), in the order of SceneKey. REQUIRES:
  // limit > 0.
  virtual absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                          const std::optional<SceneKey>& after,
                                                          uint32_t limit) = 0;

  // Returns the scene's evidence, or nothing if there is none.
  virtual absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) = 0;

  // Returns the known arms of a scene, with their backend versions: those of SourceUpdate::known,
  // and of imported evidence. A revocation makes the arms of a scene unknown about which no
  // evidence is left.
  virtual absl::StatusOr<std::set<std::pair<std::string, uint32_t>>> LoadKnownArms(
      const std::string& project, const std::string& scene) = 0;

  virtual absl::StatusOr<SceneCount> CountScenes(const std::string& project) = 0;

  // Returns how many projects have evidence. The cost does not depend on their number of scenes.
  virtual absl::StatusOr<uint64_t> CountProjects() = 0;

  // Returns the next `limit` records after `after`, or the remaining ones if there are fewer. They
  // are ordered by key and then by source number; new sources come last. The cost of a page does
  // not depend on the number of records before or after it. REQUIRES: limit > 0.
  virtual absl::StatusOr<ExportPage> Export(const SceneFilter& filter, const ExportPlace& after,
                                            uint32_t limit) = 0;

  // Like Export, for the records in quarantine.
  virtual absl::StatusOr<ExportPage> ExportQuarantined(const SceneFilter& filter,
                                                       const ExportPlace& after,
                                                       uint32_t limit) = 0;

  // Returns up to `limit` segments of the audit log with ids above `after`, ordered by id.
  virtual absl::StatusOr<std::vector<AuditSegment>> ListAudit(const AuditFilter& filter,
                                                              uint64_t after, uint32_t limit) = 0;

  // Returns the rows of a segment from number `first_row` on, ascending by number. Stops after
  // `limit` rows, or once `max_bytes` have been read. REQUIRES: limit > 0.
  virtual absl::StatusOr<std::vector<StoredAuditRow>> LoadAudit(uint64_t segment_id,
                                                                uint64_t first_row, uint32_t limit,
                                                                size_t max_bytes) = 0;

  // Examines the rows of all sessions in the order of arrival, or in the opposite order, from the
  // row after `start` on. `start` is the id of a row, which may have been removed since. With
  // kNewestFirst, 0 stands for the end of the log. Stops after `limit` rows that match, and after
  // kAuditScanRows rows. REQUIRES: limit > 0.
  virtual absl::StatusOr<AuditScan> ScanAudit(const AuditFilter& filter, AuditOrder order,
                                              uint64_t start, uint32_t limit) = 0;
};

// The store of evidence. Every implementation passes
// tests/server/storage/prior_store_conformance.h.
//
// Errors: those of PriorReader, INVALID_ARGUMENT (a value is out of bounds; trying again cannot
// help), UNAVAILABLE (the disk is full or read-only; trying again may help). A call that fails
// changes nothing.
class PriorStore : public virtual PriorReader {
 public:
  // Applies all updates or none; they are durable on return. An update is ignored if its
  // commit_sequence is at most that of the source's last stored update, because it was applied
  // before. Updates of revoked sources are ignored too.
  //
  // Audit rows are ignored if their numbers are not above the stored ones of their segment. After
  // that, the oldest rows of the audit log are removed until the log is within AuditLimits. A row
  // that cannot be written is lost and counted; it never makes a commit fail.
  //
  // If several daemons share the store, only one writer can continue a source. An update is
  // accepted if its writer made the source's last commit, or began from that commit. Any other
  // update is refused with FAILED_PRECONDITION: another writer has counted its messages, or will
  // count them.
  virtual absl::Status Commit(std::span<const SourceUpdate> updates) = 0;

  // Returns an error if commits would be lost when this process ends, for instance because the
  // store's file was removed or replaced. After an error nothing more is committed. Errors:
  // NOT_FOUND (removed or replaced), UNAVAILABLE (the check failed).
  virtual absl::Status CheckPlace() { return absl::OkStatus(); }

  virtual StoreLosses losses() const = 0;

  // Returns the scenes whose evidence any daemon has changed since the last call, for a store that
  // several daemons share. If the connection to the database was lost since then, it may return all
  // scenes.
  virtual absl::StatusOr<std::vector<SceneKey>> TakeChangedScenes() {
    return std::vector<SceneKey>();
  }

  // Makes Import, Quarantine, Promote and Revoke fail with CANCELLED while the flag is set, also a
  // call that runs already. The flag must outlive the store.
  virtual void StopChangesWhen(const std::atomic<bool>& flag) = 0;

  // Imports all records or, if one is invalid, none. A record replaces an older record of the same
  // key and source, and is ignored if the stored record is at least as new. Evidence of unknown
  // sources is added. A record of a source that was committed here is ignored: the store's own
  // evidence is newer. A record in quarantine is dropped if an imported record of its key and
  // source is at least as new.
  virtual absl::StatusOr<ImportResult> Import(std::span<const PriorRecord> records) = 0;

  // Like Import, but into the quarantine, whose records do not count as evidence. A record is
  // ignored if a record of the same key and source, in quarantine or counting, is at least as new.
  // If a source is later committed here, its records in quarantine are dropped. Error:
  // RESOURCE_EXHAUSTED (more than `max_records` would wait).
  virtual absl::StatusOr<ImportResult> Quarantine(std::span<const PriorRecord> records,
                                                  uint64_t max_records) = 0;

  // Moves the records of the selected sources out of the quarantine, with the same result as if
  // Import had received them. With `preview` nothing changes.
  virtual absl::StatusOr<ChangeResult> Promote(const SourceFilter& filter,
                                               const Preview& preview) = 0;

  // Removes exactly the evidence of the selected sources, in quarantine or not, and refuses their
  // later commits and imports. If no source has the filter's id, and no project is set, a later
  // source with this id is refused too. The log of administrators cannot be revoked. With `preview`
  // nothing changes. REQUIRES: the filter has more than a project.
  virtual absl::StatusOr<ChangeResult> Revoke(const SourceFilter& filter,
                                              const Preview& preview) = 0;
};

// A PriorStore with a writing thread and a reading thread of its own. Thread-safe. Callbacks run on
// those threads; they must neither wait nor throw.
class AsyncPriorStore {
 public:
  using CommitCallback = std::function<void(const absl::Status&)>;
  using Job = std::function<void(PriorStore&)>;
  using ReadJob = std::function<void(PriorReader&)>;

  virtual ~AsyncPriorStore() = default;

  // Queues the update for a group commit. `done` is called once: with OK when it is durable, with
  // the error of a failed commit, or, on the caller's thread, with RESOURCE_EXHAUSTED if the queue
  // is full or closed. After an error the caller may offer the same update again.
  virtual void Commit(SourceUpdate update, CommitCallback done) = 0;

  // Runs `job` on the writing thread, after the commits that were offered before it. Use it to
  // write, or to read exact values. Nothing is committed while it runs, and the callbacks of all
  // commits that it can read have already run. Returns false if the queue is full or closed; the
  // job will not run then.
  virtual bool Submit(Job job) = 0;

  // Runs `job` on the reading thread, where it delays no commit. It reads one snapshot of the
  // store. The snapshot has all commits whose callbacks ran before the call, and perhaps some that
  // are under way. Returns false if the queue is full or closed; the job will not run then.
  virtual bool Read(ReadJob job) = 0;

  // Returns false in two cases:
  // - from a commit that fails because of the disk until the next commit that succeeds,
  // - while a read takes too long.
  virtual bool healthy() const = 0;

  // Returns PriorStore::losses after the latest commit.
  virtual StoreLosses losses() const = 0;
};

}  // namespace sweepstake::priors
