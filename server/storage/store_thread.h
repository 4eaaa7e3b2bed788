// Puts a prior store on a thread of its own and groups commits, so that an fsync serves many
// sessions and nobody else waits for one.
//
// Thread-safe. Owns the store; the destructor runs what is queued, then ends the thread. A commit
// waits at most `group_interval` for company, and a job or the end of the queue's life sends it off
// at once. A group that fails on one wrong update is committed again update by update, so that one
// cannot block the others. Once it is closing, a disk that fails is not tried again: what is queued
// then fails at once, so that an end takes no longer than one commit.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <variant>
#include <vector>

#include "server/priors/prior_store.h"

namespace sweepstake::storage {

struct StoreThreadOptions {
  std::chrono::milliseconds group_interval{
      50};                     // what a crash may cost, and the longest delay of an acknowledgement
  size_t group_rows = 500;     // a group is sent off early when it has this many increments
  size_t max_queued = 65'536;  // updates and jobs; the next one is refused
};

class StoreThread final : public priors::AsyncPriorStore {
 public:
  explicit StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options = {});
  ~StoreThread() override;
  // Runs what is queued and ends the thread; later commits and jobs are refused. Idempotent, one
  // caller at a time.
  void Close();
  StoreThread(const StoreThread&) = delete;
  StoreThread& operator=(const StoreThread&) = delete;

  void Commit(priors::SourceUpdate update, CommitCallback done) override;
  bool Submit(Job job) override;
  bool healthy() const override { return healthy_.load(std::memory_order_relaxed); }

 private:
  struct PendingCommit {
    priors::SourceUpdate update;
    CommitCallback done;
  };
  using Item = std::variant<PendingCommit, Job>;
  using TimePoint = std::chrono::steady_clock::time_point;

  // False: full or closing.
  bool Enqueue(Item item, size_t rows);
  void Loop();
  void WaitForGroup(std::unique_lock<std::mutex>& lock);
  // The commits at the queue's front, as many as a group may have.
  std::vector<PendingCommit> TakeGroup();
  void CommitGroup(std::vector<PendingCommit> group, bool closing);
  void CommitOneByOne(std::vector<PendingCommit>& group);
  void Finish(PendingCommit& commit, const absl::Status& status);

  const std::unique_ptr<priors::PriorStore> store_;
  const StoreThreadOptions options_;
  std::atomic<bool> healthy_{true};

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;  // guarded by mutex_
  size_t queued_rows_ = 0;  // guarded by mutex_; of the commits in the queue
  size_t queued_jobs_ = 0;  // guarded by mutex_
  bool closing_ = false;    // guarded by mutex_
  std::thread thread_;      // last: starts when the rest is there
};

}  // namespace sweepstake::storage
