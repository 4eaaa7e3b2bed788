// Folds the evidence of old sessions together, so that a store keeps its size (FoldSources of
// sqlite_prior_store.h says what that is).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "absl/status/status.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::storage {

struct FoldPlan {
  uint32_t days = 0;  // sessions that were last seen longer ago are folded; 0 folds none
  std::chrono::milliseconds interval = std::chrono::hours(24);
  // Between two steps, so that folding takes little of the store's thread while it has much to do.
  std::chrono::milliseconds pause{100};
  uint32_t rows_per_step = kRowsPerFold;
};

// What a run has done, also if it failed or was stopped half-way.
struct FoldRun {
  absl::Status status;
  uint64_t source_count = 0;  // sources whose evidence was folded
  uint64_t record_count = 0;  // rows of evidence that this took
};

// One run through all evidence, step by step. Not thread-safe; its owner lets the store's thread do
// each step.
class FoldWalk {
 public:
  // Folds what is too old for the plan at `unix_now_s`.
  FoldWalk(const FoldPlan& plan, uint64_t unix_now_s);

  // Does the next step; an error is the walk's end. REQUIRES: !done(); `store` is of
  // OpenSqlitePriorStore.
  void Step(priors::PriorStore& store);
  // Ends the walk. REQUIRES: !status.ok().
  void Fail(const absl::Status& status);
  bool done() const { return done_; }
  const FoldRun& run() const { return run_; }

 private:
  const uint32_t rows_per_step_;
  uint64_t last_unix_s_;  // when sessions that are folded were last seen at the latest
  FoldPlace place_;
  FoldRun run_;
  bool done_ = false;
};

// Looks through all evidence at its start and after each interval, step by step. Each step is a job
// of the store's thread and takes as long as a group of commits; commits that come meanwhile are
// done before the next one.
class EvidenceFolding {
 public:
  using OnDone = std::function<void(const FoldRun&)>;

  // `unix_now_s` is the wall clock; it is asked, and `on_done` told of each run, on a thread of its
  // own. REQUIRES: the store runs one of OpenSqlitePriorStore, and lives longer, or is closed.
  EvidenceFolding(priors::AsyncPriorStore& store, const FoldPlan& plan,
                  std::function<uint64_t()> unix_now_s, OnDone on_done);
  // Waits for the step that is under way.
  ~EvidenceFolding() = default;
  EvidenceFolding(const EvidenceFolding&) = delete;
  EvidenceFolding& operator=(const EvidenceFolding&) = delete;

  // Begins no further step; does not wait.
  void Stop() { thread_.request_stop(); }

 private:
  void Loop(const std::stop_token& stop);
  FoldRun RunOnce(const std::stop_token& stop);
  void RunStep(FoldWalk& walk);
  // Returns false once it is to stop.
  bool Sleep(const std::stop_token& stop, std::chrono::milliseconds duration);

  priors::AsyncPriorStore& store_;
  const FoldPlan plan_;
  const std::function<uint64_t()> unix_now_s_;
  const OnDone on_done_;
  std::mutex mutex_;  // of the sleep alone
  std::condition_variable_any sleep_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace sweepstake::storage
