// What was learnt, as it is kept: increments per source (session), so that a retry is never counted
// twice and a bad source can be taken out again. The sum over sources is what is served.
//
// Plain values and two interfaces; no I/O here. A PriorStore is used by one thread at a time; an
// AsyncPriorStore by any. Strings are UTF-8; stores keep them as text and compare them byte by
// byte.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/priors/audit_rows.h"

namespace sweepstake::priors {

// What a piece of evidence is about. Evidence with different keys is never merged.
struct EvidenceKey {
  std::string project;
  std::string scene;
  std::string context_bucket;  // empty: the only bucket
  std::string arm;
  uint32_t backend_version = 1;
  std::string machine_class;  // empty: the unknown class
  uint32_t reward_version = 1;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const EvidenceKey&, const EvidenceKey&) = default;
};

// An amount of evidence, without any prior.
struct Evidence {
  double alpha = 0;  // finite, 0 to < 1e15
  double beta = 0;   // finite, 0 to < 1e15
  uint64_t window_count = 0;
  uint64_t bail_out_count = 0;

  Evidence& operator+=(const Evidence& other);
  friend bool operator==(const Evidence&, const Evidence&) = default;
};

inline Evidence& Evidence::operator+=(const Evidence& other) {
  alpha += other.alpha;
  beta += other.beta;
  window_count += other.window_count;
  bail_out_count += other.bail_out_count;
  return *this;
}

struct KeyedEvidence {
  EvidenceKey key;
  Evidence evidence;

  friend bool operator==(const KeyedEvidence&, const KeyedEvidence&) = default;
};

// How far a source has come. Numbers are below 2^63, but for the seed.
struct SourceProgress {
  std::string source_id;
  uint64_t commit_sequence = 0;   // from 1, one more at each commit of the source
  uint64_t message_sequence = 0;  // every client message up to it is included
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
  uint64_t frame_count = 0;  // frames in those messages, learnt from or left out
  uint64_t seed = 0;

  friend bool operator==(const SourceProgress&, const SourceProgress&) = default;
};

// One atomic step of one source.
struct SourceUpdate {
  SourceProgress progress;
  std::vector<KeyedEvidence> increments;  // may be empty; a key occurs once
  AuditRows audit;
};

// What is kept of a source.
struct SourceState {
  SourceProgress progress;
  std::vector<KeyedEvidence> evidence;  // ordered by key
  uint32_t audit_segment = 0;           // the last one stored; 0: none
};

// Evidence of one key, summed over sources.
struct PriorSum {
  Evidence evidence;
  uint64_t source_count = 0;
};

// Sums of several keys.
struct PriorSums {
  std::vector<PriorSum> sums;  // in the order of the keys asked for
  uint64_t source_count = 0;   // distinct sources behind any of them
};

// Names a scene's posteriors. Ordered by project, then scene, then machine class, then reward
// version.
struct SceneKey {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 1;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SceneKey&, const SceneKey&) = default;
};

// Every arm of one scene, summed over sources and context buckets.
struct SceneEvidence {
  struct Arm {
    std::string name;
    uint32_t backend_version = 1;
    Evidence evidence;
  };
  SceneKey key;
  std::vector<Arm> arms;  // ordered by name, then version
  uint64_t source_count = 0;
};

// Empty fields match everything.
struct SceneFilter {
  std::string project;
  std::string scene;
};

// What one source taught about one key, to carry between stores.
struct PriorRecord {
  EvidenceKey key;
  std::string source_id;
  uint64_t source_sequence = 0;  // the source's commit that is included last; from 1
  Evidence evidence;

  friend bool operator==(const PriorRecord&, const PriorRecord&) = default;
};

struct ImportResult {
  uint64_t applied_count = 0;    // new or newer
  uint64_t unchanged_count = 0;  // already known, or of a revoked source
};

// Where evidence lives. Every implementation passes tests/server/storage/prior_store_conformance.h.
//
// Errors: INVALID_ARGUMENT (a value out of bounds; trying again cannot help), UNAVAILABLE (disk
// full, read-only, locked; trying again may help), DATA_LOSS (the file is broken). After an error
// nothing of the call has been kept.
class PriorStore {
 public:
  virtual ~PriorStore() = default;

  // Applies all updates or none. An update whose commit sequence is at or below the source's stored
  // one was applied before and is ignored, as is one of a revoked source. Durable on return.
  //
  // Audit rows are kept as far as the limits allow and as they go on from what is stored of their
  // segment: what is stored is always its beginning. Rows that do not are left out; they never make
  // a commit fail.
  virtual absl::Status Commit(std::span<const SourceUpdate> updates) = 0;

  virtual absl::StatusOr<PriorSums> LoadPriors(std::span<const EvidenceKey> keys) = 0;

  // Absent: never committed here (an imported source is not a session of this store), or revoked.
  virtual absl::StatusOr<std::optional<SourceState>> LoadSource(const std::string& source_id) = 0;

  // Up to `limit` scenes after `after` (exclusive), in the order of SceneKey. REQUIRES: limit > 0.
  virtual absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                          const std::optional<SceneKey>& after,
                                                          uint32_t limit) = 0;

  // Absent: no evidence of that scene.
  virtual absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) = 0;

  // Up to `limit` records after `after` (exclusive), ordered by key, then source. REQUIRES: limit >
  // 0.
  virtual absl::StatusOr<std::vector<PriorRecord>> Export(const SceneFilter& filter,
                                                          const std::optional<PriorRecord>& after,
                                                          uint32_t limit) = 0;

  // Takes all records or, when one is wrong, none. A record replaces an older one of the same key
  // and source and is ignored when the store's is as new. Evidence of sources the store has not
  // seen is added.
  virtual absl::StatusOr<ImportResult> Import(std::span<const PriorRecord> records) = 0;

  // Takes out exactly the source's evidence, and keeps the source from coming back by a commit or
  // an import. Returns the number of records removed; 0 for an unknown source, which is barred too.
  virtual absl::StatusOr<uint64_t> Revoke(const std::string& source_id) = 0;

  // Up to `limit` segments of the audit log with ids above `after`, in the order of their ids.
  virtual absl::StatusOr<std::vector<AuditSegment>> ListAudit(const AuditFilter& filter,
                                                              uint64_t after, uint32_t limit) = 0;

  // Rows of a segment from number `first_row` (from 1) on: up to `limit`, and no more after
  // `max_bytes` have been read. Empty: there are none. REQUIRES: limit > 0.
  virtual absl::StatusOr<std::vector<std::string>> LoadAudit(uint64_t segment_id,
                                                             uint64_t first_row, uint32_t limit,
                                                             size_t max_bytes) = 0;
};

// A PriorStore behind a thread of its own. Thread-safe. Callbacks run on that thread, must not wait
// and must not throw.
class AsyncPriorStore {
 public:
  using CommitCallback = std::function<void(const absl::Status&)>;
  using Job = std::function<void(PriorStore&)>;

  virtual ~AsyncPriorStore() = default;

  // Puts the update into the next group commit. `done` runs once: OK when it is durable;
  // RESOURCE_EXHAUSTED at once, on the caller's thread, when the queue is full. After an error the
  // caller keeps the update and may offer the same one again.
  virtual void Commit(SourceUpdate update, CommitCallback done) = 0;

  // Runs `job` after the commits that were offered before it. False: the queue is full or closed,
  // and it will not run.
  virtual bool Submit(Job job) = 0;

  // False from a commit that failed because of the disk until one succeeds.
  virtual bool healthy() const = 0;
};

}  // namespace sweepstake::priors
