// The storage of learnt evidence. It is kept as increments per source (session), so that a retry is
// never counted twice and a bad source can be removed. Readers get the sum over the sources.
//
// These are plain values and interfaces without I/O. A PriorReader or PriorStore is used by one
// thread at a time, an AsyncPriorStore by any. Strings are UTF-8; stores keep them as text and
// compare them byte by byte.
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine_client/decider/pooling/prior_record.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "server/sessions/audit_rows.h"

namespace sweepstake::priors {

using sweepstake::Evidence;
using sweepstake::EvidenceKey;
using sweepstake::PriorRecord;

// Returns the evidence in whole units of 2⁻²⁰, as stores keep it: sums up to 2³³ are exact then, in
// any order, so that what is taken out again leaves no trace.
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
  uint64_t commit_sequence = 0;   // begins at 1 and grows at each commit of the source
  uint64_t message_sequence = 0;  // every client message up to this one is included
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
  uint64_t frame_count = 0;  // frames in those messages, learnt from or not
  uint64_t seed = 0;

  friend bool operator==(const SourceProgress&, const SourceProgress&) = default;
};

// Where a source comes from. It is kept from the source's first update on.
struct SourceOrigin {
  std::string build;     // of the game; empty if unknown
  int64_t token_id = 0;  // that the session began with; 0 for none

  friend bool operator==(const SourceOrigin&, const SourceOrigin&) = default;
};

// Who writes a source: one run of its session, in one daemon. A session that goes on in another
// daemon, or that is begun from the store again, is another writer.
struct SourceWriter {
  uint64_t id = 0;                // random; 0 for a source that only one daemon ever writes
  uint64_t resumed_sequence = 0;  // the commit of the source that it began from; 0: from none
};

// One atomic step of one source.
struct SourceUpdate {
  SourceProgress progress;
  uint64_t unix_time_s = 0;               // the wall clock's time of the step, below 2^63
  std::vector<KeyedEvidence> increments;  // may be empty; a key occurs at most once
  AuditRows audit;
  SourceOrigin origin = {};
  SourceWriter writer = {};
};

// Returns whether a commit has failed because of an update in it, and would again: the update is
// invalid, or its source has another writer.
inline bool IsRefusal(const absl::Status& commit) {
  return absl::IsInvalidArgument(commit) || absl::IsFailedPrecondition(commit);
}

// The state of a source in a store.
struct SourceState {
  SourceProgress progress;
  std::vector<KeyedEvidence> evidence;  // ordered by key
  uint32_t audit_segment = 0;           // the last one stored, or 0
  // Times of the source's first and last commit here.
  uint64_t created_unix_s = 0;
  uint64_t last_seen_unix_s = 0;
};

// Names the posteriors of a scene. Keys are ordered by project, scene, machine class and reward
// version.
struct SceneKey {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 1;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SceneKey&, const SceneKey&) = default;
};

// Returns the key of an arm's evidence about the scene.
inline EvidenceKey EvidenceKeyOf(const SceneKey& scene, const std::string& arm,
                                 uint32_t backend_version, std::string_view measured_by) {
  return {.project = scene.project,
          .scene = scene.scene,
          .measured_by = std::string(measured_by),
          .arm = arm,
          .backend_version = backend_version,
          .machine_class = scene.machine_class,
          .reward_version = scene.reward_version};
}

// The evidence of every arm of one scene, summed over sources.
struct SceneEvidence {
  struct Arm {
    std::string name;
    uint32_t backend_version = 1;
    Evidence live;  // measured by the frame thread
    Evidence lane;  // measured by the shadow lane
    // When a source that taught something of the arm taught last, of this arm or another: the
    // latest of its kSourcesOfAge last ones; 0 if unknown.
    uint64_t last_seen_unix_s = 0;

    Evidence& of(std::string_view measured_by) { return measured_by.empty() ? live : lane; }
  };
  SceneKey key;
  std::vector<Arm> arms;  // ordered by name and version
  uint64_t source_count = 0;

  // Returns the arm, which is added if it is not there.
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

// Returns the arm's evidence as decision::PriorFor reads it.
inline decision::ArmEvidence EvidenceOf(const SceneEvidence::Arm& arm) {
  return {.live = {arm.live.alpha, arm.live.beta},
          .lane = {arm.lane.alpha, arm.lane.beta},
          .bail_out_count = arm.live.bail_out_count};
}

// Number of latest sources, per arm and kind, whose age is looked up.
inline constexpr uint32_t kSourcesOfAge = 8;

// What one source taught about one scene on one class of machines.
struct SceneSource {
  std::string id;
  std::string build;              // empty if unknown
  uint64_t last_seen_unix_s = 0;  // 0 if unknown
  SceneEvidence evidence;         // of the one source
};

// An empty field matches everything.
struct SceneFilter {
  std::string project;
  std::string scene;
  std::vector<std::string> projects = {};  // any of these, and `project`

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SceneFilter&, const SceneFilter&) = default;
  bool Matches(std::string_view of_project, std::string_view of_scene) const {
    return (project.empty() || project == of_project) && (scene.empty() || scene == of_scene) &&
           (projects.empty() ||
            std::find(projects.begin(), projects.end(), of_project) != projects.end());
  }
};

// How many scenes of a project a store has.
struct SceneCount {
  uint64_t names = 0;
  uint64_t keys = 0;  // a name counts once per machine class and reward version
};

// A place in an export: behind the record of a key and a source. By default before all records.
struct ExportPlace {
  EvidenceKey key;
  uint64_t source_number = 0;  // given by the store, from 1; it stays the source's
};

struct ExportPage {
  std::vector<PriorRecord> records;
  ExportPlace next;  // behind the last record
};

struct ImportResult {
  uint64_t applied_count = 0;    // records that were new or newer
  uint64_t unchanged_count = 0;  // records that were known, or of a session or a revoked source
};

// Of which sources a scene's new sessions learn.
inline constexpr uint32_t kSourcesOfScene = 32;
inline constexpr uint32_t kSourcesOfOtherClass = 4;
inline constexpr uint32_t kOtherClasses = 8;

// Which sources; what is not set matches all.
struct SourceFilter {
  std::string id = {};
  std::string project = {};  // those with evidence of it, of which that of others stays
  std::string build = {};
  int64_t token_id = 0;
  uint64_t from_unix_s = 0;  // that began then or later; an imported source began at 0
  uint64_t until_unix_s = (1ull << 63) - 1;  // that began then or before

  friend bool operator==(const SourceFilter&, const SourceFilter&) = default;
};

struct RevokeResult {
  uint64_t source_count = 0;  // that were not revoked before
  uint64_t record_count = 0;
  uint64_t window_count = 0;  // visits of the lane count, too

  friend bool operator==(const RevokeResult&, const RevokeResult&) = default;
};

struct PromoteResult {
  uint64_t source_count = 0;  // that had records in quarantine
  uint64_t record_count = 0;
  uint64_t window_count = 0;  // visits of the lane count, too
  uint64_t scene_count = 0;   // whose evidence changes; one per machine class and reward version

  friend bool operator==(const PromoteResult&, const PromoteResult&) = default;
};

class PriorReader;

// Whether a change of the evidence is only shown: then nothing changes, and who wants to reads the
// store as it would be. It converts from the answer to that.
class Preview {
 public:
  using Look = std::function<void(PriorReader&)>;

  Preview(bool is_preview) : is_preview_(is_preview) {}  // NOLINT(google-explicit-constructor)
  // Where the store begins anew, because others were in the way, `look` runs again.
  explicit Preview(Look look) : is_preview_(true), look_(std::move(look)) {}

  explicit operator bool() const { return is_preview_; }
  void Show(PriorReader& store) const {
    if (look_) look_(store);
  }

 private:
  bool is_preview_;
  Look look_;
};

// What a store has. Evidence in quarantine is in ExportQuarantined alone. Errors: UNAVAILABLE (the
// disk cannot read, or the file is locked), DATA_LOSS (what was asked for is damaged).
class PriorReader {
 public:
  virtual ~PriorReader() = default;

  // Returns what sources taught about the scene on any class of machines, with this version of the
  // reward: of each arm what kSourcesOfScene of the latest sources of its class say, and
  // kSourcesOfOtherClass of each of kOtherClasses others, which decision::ChooseSources chooses so
  // that no token outnumbers the others. The cost does not depend on how many sources there are.
  virtual absl::StatusOr<std::vector<SceneSource>> LoadSources(const SceneKey& scene) = 0;

  // Returns nothing if the source was never committed here (an imported source is not a session of
  // this store) or is revoked.
  virtual absl::StatusOr<std::optional<SourceState>> LoadSource(const std::string& source_id) = 0;

  // Returns up to `limit` scenes after `after` (exclusive), in the order of SceneKey. REQUIRES:
  // limit > 0.
  virtual absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                          const std::optional<SceneKey>& after,
                                                          uint32_t limit) = 0;

  // Returns nothing if there is no evidence of that scene.
  virtual absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) = 0;

  virtual absl::StatusOr<SceneCount> CountScenes(const std::string& project) = 0;

  // Returns how many projects have evidence. The cost does not depend on how many scenes they have.
  virtual absl::StatusOr<uint64_t> CountProjects() = 0;

  // Returns the next records behind `after`: `limit` of them, or all if there are fewer. They are
  // ordered by key, and those of a key by the sources' numbers, in which new sources come last. The
  // cost of a page does not depend on how many records come before or after it. REQUIRES: limit >
  // 0.
  virtual absl::StatusOr<ExportPage> Export(const SceneFilter& filter, const ExportPlace& after,
                                            uint32_t limit) = 0;

  // Returns the next records behind `after` that wait in quarantine, in the same order.
  virtual absl::StatusOr<ExportPage> ExportQuarantined(const SceneFilter& filter,
                                                       const ExportPlace& after,
                                                       uint32_t limit) = 0;

  // Returns up to `limit` segments of the audit log with ids above `after`, ordered by id.
  virtual absl::StatusOr<std::vector<AuditSegment>> ListAudit(const AuditFilter& filter,
                                                              uint64_t after, uint32_t limit) = 0;

  // Returns the rows of a segment from number `first_row` on, in the order of their numbers: up to
  // `limit`, and no more once `max_bytes` have been read. REQUIRES: limit > 0.
  virtual absl::StatusOr<std::vector<AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit, size_t max_bytes) = 0;
};

// The store of evidence. Every implementation passes
// tests/server/storage/prior_store_conformance.h.
//
// Errors: those of PriorReader, INVALID_ARGUMENT (a value is out of bounds; trying again cannot
// help), UNAVAILABLE (the disk is full or read-only; trying again may help). After an error nothing
// of the call has been kept.
class PriorStore : public PriorReader {
 public:
  // Applies all updates or none; they are durable on return. An update whose commit sequence is not
  // above the source's stored one was applied before and is ignored, as is one of a revoked source.
  //
  // Audit rows whose numbers are not above those stored of their segment are ignored. Then the
  // oldest rows of the log are removed until it is within its limits. A row that cannot be written
  // is lost and counted; it never makes a commit fail.
  //
  // Of the writers of a source only one goes on. A store that several daemons share refuses an
  // update of another writer than that of the source's last commit, unless the writer began from
  // that commit: its messages were, or will be, counted by another. Error: FAILED_PRECONDITION.
  virtual absl::Status Commit(std::span<const SourceUpdate> updates) = 0;

  // Returns an error if what is committed would be lost with this process: nothing more is
  // committed then. A store on a file finds out that it was removed, or another put in its place.
  // Errors: NOT_FOUND (so it is), UNAVAILABLE (it cannot be told).
  virtual absl::Status CheckPlace() { return absl::OkStatus(); }

  // Returns how many audit rows of successful commits could not be written since the store was
  // opened.
  virtual uint64_t lost_audit_row_count() const = 0;

  // Returns the scenes whose evidence was changed since the last call, by whomever, in a store that
  // several daemons share. All may be among them where the connection is a new one.
  virtual absl::StatusOr<std::vector<SceneKey>> TakeChangedScenes() {
    return std::vector<SceneKey>();
  }

  // Imports all records or, if one is invalid, none. A record replaces an older one of the same key
  // and source, and is ignored if the stored one is as new. Evidence of unknown sources is added. A
  // record of a source that was committed here is ignored: the store's own evidence is newer. What
  // waits in quarantine and is no newer than an imported record of its key and source is dropped.
  virtual absl::StatusOr<ImportResult> Import(std::span<const PriorRecord> records) = 0;

  // The same into the quarantine, where it is no evidence of any scene: what is there, or counts
  // already, is replaced by what is newer alone. A source that is committed here loses what waits
  // of it. Error: RESOURCE_EXHAUSTED (more than `max_records` would wait).
  virtual absl::StatusOr<ImportResult> Quarantine(std::span<const PriorRecord> records,
                                                  uint64_t max_records) = 0;

  // Takes the sources' records out of the quarantine, into what counts: then the store is as if
  // Import had had them. With `preview` nothing changes.
  virtual absl::StatusOr<PromoteResult> Promote(const SourceFilter& filter,
                                                const Preview& preview) = 0;

  // Removes exactly the evidence of the sources, in quarantine and out of it, and bars them from
  // later commits and imports. An unknown id is barred too, unless a project is named. The log of
  // administrators is not a source. With `preview` nothing changes. REQUIRES: an id, a build, a
  // token or a time.
  virtual absl::StatusOr<RevokeResult> Revoke(const SourceFilter& filter,
                                              const Preview& preview) = 0;
};

// A PriorStore that runs on threads of its own, one that writes and one that reads. Thread-safe.
// Callbacks run on those threads; they must neither wait nor throw.
class AsyncPriorStore {
 public:
  using CommitCallback = std::function<void(const absl::Status&)>;
  using Job = std::function<void(PriorStore&)>;
  using ReadJob = std::function<void(PriorReader&)>;

  virtual ~AsyncPriorStore() = default;

  // Puts the update into the next group commit. `done` runs once: with OK when the update is
  // durable, or with RESOURCE_EXHAUSTED at once, on the caller's thread, if the queue is full.
  // After an error the caller may offer the same update again.
  virtual void Commit(SourceUpdate update, CommitCallback done) = 0;

  // Runs `job` on the writing thread, after the commits that were offered before it. For what
  // writes, and for what must be read exactly: nothing is committed while it runs, and whatever it
  // sees has been told to the commits' callbacks before. Returns false if the queue is full or
  // closed; then the job will not run.
  virtual bool Submit(Job job) = 0;

  // Runs `job` on the reading thread, where it delays no commit. All that it reads is one state of
  // the store, which has at least the commits whose callbacks ran before the call; of those that
  // are under way it may have some. Returns false as Submit does.
  virtual bool Read(ReadJob job) = 0;

  // Returns false after a commit failed because of the disk, until one succeeds, and while a read
  // does not come to its end.
  virtual bool healthy() const = 0;

  // Returns PriorStore::lost_audit_row_count after the latest commit.
  virtual uint64_t lost_audit_row_count() const = 0;
};

}  // namespace sweepstake::priors
