// Runs a prior store on its own thread and groups commits, so that one fsync serves many sessions
// and no other thread waits for it.
//
// Thread-safe. It owns the store; the destructor runs what is queued, then ends the thread. A
// commit waits at most `group_interval` for others, and is started at once by a job or by Close. If
// a group fails because of an invalid update, its halves are committed by themselves, and theirs,
// so that only that one is refused. While closing, a disk that fails is not tried again: what is
// still queued fails at once, so that closing takes no longer than one commit.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <variant>
#include <vector>

#include "server/priors/prior_store.h"

namespace sweepstake::storage {

struct StoreThreadOptions {
  // The maximum delay of an acknowledgement, and the time whose updates a crash may lose.
  std::chrono::milliseconds group_interval{50};
  size_t group_rows = 500;  // a group with this many increments is committed early
  // If false there is no thread: the owner calls RunNext.
  bool own_thread = true;
  size_t max_queued = 65'536;  // updates and jobs; beyond it they are refused
  // Is told, on the store's thread, that commits begin to fail and why, and with OK that they
  // succeed again.
  std::function<void(const absl::Status&)> on_health = [](const absl::Status&) {};
  // Told on the store's thread of each update that can never be stored, and why.
  std::function<void(const priors::SourceUpdate&, const absl::Status&)> on_refusal = {};
  // Told on the store's thread how long each commit of the store took. May be empty.
  std::function<void(std::chrono::nanoseconds)> on_commit = {};
};

class StoreThread final : public priors::AsyncPriorStore {
 public:
  explicit StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options = {});
  ~StoreThread() override;
  // Runs what is queued and ends the thread; later commits and jobs are refused. It may be called
  // again, by one thread at a time.
  void Close();
  StoreThread(const StoreThread&) = delete;
  StoreThread& operator=(const StoreThread&) = delete;

  void Commit(priors::SourceUpdate update, CommitCallback done) override;
  bool Submit(Job job) override;
  bool healthy() const override { return healthy_.load(std::memory_order_relaxed); }
  // Runs the next group of commits, or the next job. Returns false if nothing is queued. REQUIRES:
  // there is no own thread.
  bool RunNext();
  // Returns how many updates and jobs wait.
  size_t queued_count() const;
  uint64_t lost_audit_row_count() const override {
    return lost_audit_row_count_.load(std::memory_order_relaxed);
  }

 private:
  struct PendingCommit {
    priors::SourceUpdate update;
    CommitCallback done;
  };
  using Item = std::variant<PendingCommit, Job>;
  using TimePoint = std::chrono::steady_clock::time_point;

  // Returns false if the queue is full or closing.
  bool Enqueue(Item item, size_t rows);
  void Loop();
  // Takes the next group or job off the queue, and runs it without the lock. REQUIRES: the queue is
  // not empty.
  void RunFront(std::unique_lock<std::mutex>& lock);
  void WaitForGroup(std::unique_lock<std::mutex>& lock);
  // Takes commits off the queue's front, as many as a group may have.
  std::vector<PendingCommit> TakeGroup();
  void CommitGroup(std::vector<PendingCommit> group, bool closing);
  // `updates` are those of the group.
  void CommitOrHalve(std::span<PendingCommit> group, std::span<const priors::SourceUpdate> updates);
  absl::Status CommitNow(std::span<const priors::SourceUpdate> updates);
  void Finish(PendingCommit& commit, const absl::Status& status);

  const std::unique_ptr<priors::PriorStore> store_;
  const StoreThreadOptions options_;
  std::atomic<bool> healthy_{true};
  std::atomic<uint64_t> lost_audit_row_count_{0};  // the store's, after the latest commit

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;  // guarded by mutex_
  size_t queued_rows_ = 0;  // guarded by mutex_; of the commits in the queue
  size_t queued_jobs_ = 0;  // guarded by mutex_
  bool closing_ = false;    // guarded by mutex_
  std::thread thread_;      // the last member, because it uses the others
};

}  // namespace sweepstake::storage
