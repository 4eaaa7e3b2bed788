// Runs a prior store on a thread of its own, which commits the updates of many sessions in groups.
// One fsync serves a whole group, and no other thread waits for the disk. Reads run on another
// thread (read_thread.h).
//
// Thread-safe. Owns the store. The destructor runs the queued commits and jobs, then ends the
// threads.
//
// - A commit waits at most `group_interval` for further commits. Close starts it at once.
// - A job does not split a group. It runs after the commits that were offered before it, and also
//   after later commits of the same group.
// - If a group fails because an update is refused, the group is halved repeatedly, so that only
//   that update fails.
// - If the disk fails while the thread is closing, queued commits fail at once, so that closing
//   takes no longer than one commit.
//
// PriorStore::CheckPlace is called every `check_interval`, after a commit that fails, and when the
// thread ends. A removed file is therefore found even if nothing is committed.
//
// Reads that must see every commit before them (exact reads) run as jobs. A decision loop receives
// a job's result after the results of all commits that the job has seen, and before the results of
// all later commits. Exact reads are:
// - resuming a session. Its last commit may still be queued when its client reconnects. A session
//   that started from an older state would count messages twice, or use the number of a commit
//   again.
// - starting a session of a scene that is not stored, which counts towards the quotas. A scene must
//   count once: as stored, or among the scenes in memory (server/sessions/new_scenes.h).
// - reading the sums to which the increments of later commits are added (events/event_bus.h).
// - checking the quota before an import.
//
// Other reads run on the reading thread: whether the scene of a new session is stored, its priors,
// listings, exports and the audit log. Each sees a state of the store that includes all commits
// acknowledged before the request.
//
// Close lets both threads run what is queued. It waits for the commits first, so that a stuck read
// does not delay them. The reading connection is closed before the store, because only the store's
// connection can move the write-ahead log into the file.
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
#include <vector>

#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"

namespace sweepstake::storage {

struct StoreThreadOptions {
  // Maximum time that a commit waits for further commits. A crash loses updates of this time, which
  // were not acknowledged.
  std::chrono::milliseconds group_interval{50};
  size_t group_rows = 500;  // a group with this many rows (RowCount) is committed at once
  // If false there are no threads, and the owner calls RunNext and RunNextRead.
  bool own_thread = true;
  size_t max_queued = 65'536;  // limit of queued updates and jobs, and of reads; more are refused
  std::chrono::milliseconds max_read = ReadThreadOptions().max_read;
  std::chrono::milliseconds check_interval{2'000};
  // Called on the store's thread every `check_interval`, and when the thread ends. May be empty.
  std::function<void(priors::PriorStore&)> on_check = {};
  // Called on the store's thread with the cause when commits begin to fail, and with OK when they
  // succeed again. NOT_FOUND means that the file was removed, replaced or cut
  // (PriorStore::CheckPlace). NOT_FOUND is reported even if commits already fail. If the file is
  // back and the disk still fails, the disk error is reported again.
  std::function<void(const absl::Status&)> on_health = [](const absl::Status&) {};
  // Called on the store's thread after `on_health`, at each check that returns NOT_FOUND. It can
  // save the store elsewhere. `last` is true in the last call, when the thread ends. May be empty.
  std::function<void(priors::PriorStore&, bool last)> on_misplaced = {};
  // Called on the store's thread with each update that can never be stored, and the error.
  std::function<void(const priors::SourceUpdate&, const absl::Status&)> on_refusal = {};
  // Called on the store's thread with the duration of each commit. May be empty.
  std::function<void(std::chrono::nanoseconds)> on_commit = {};
  // ReadThreadOptions::on_read.
  std::function<void(std::chrono::nanoseconds)> on_read = {};
};

class StoreThread final : public priors::AsyncPriorStore {
 public:
  // If `reads` is null, reads run as jobs on the store's thread.
  explicit StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options = {},
                       std::unique_ptr<ReadConnection> reads = nullptr);
  ~StoreThread() override;
  // Runs what is queued and ends the threads. Later commits, jobs and reads are refused. May be
  // called again, by one thread at a time.
  void Close();
  // Makes running and later imports, promotions and revocations fail with CANCELLED. Commits and
  // reads continue.
  void StopChanges() { stops_changes_ = true; }
  StoreThread(const StoreThread&) = delete;
  StoreThread& operator=(const StoreThread&) = delete;

  void Commit(priors::SourceUpdate update, CommitCallback done) override;
  bool Submit(Job job) override;
  bool Read(ReadJob job) override;
  bool healthy() const override { return can_write() && can_read(); }
  bool can_write() const { return can_write_.load(std::memory_order_relaxed); }
  // Returns false while a read takes longer than max_read.
  bool can_read() const { return reads_ == nullptr || !reads_->stuck(); }
  // Runs the next job if all commits before it have been taken, otherwise the next group of
  // commits. Returns false if nothing is queued. REQUIRES: own_thread is false.
  bool RunNext();
  bool RunNextRead() { return reads_ != nullptr && reads_->RunNext(); }
  // Returns the number of waiting updates and jobs.
  size_t queued_count() const;
  size_t queued_read_count() const { return reads_ == nullptr ? 0 : reads_->queued_count(); }
  priors::StoreLosses losses() const override;

 private:
  struct PendingCommit {
    priors::SourceUpdate update;
    CommitCallback done;
  };
  struct PendingJob {
    Job run;
    uint64_t commits_before = 0;  // number of commits that were offered before this job
  };
  using TimePoint = std::chrono::steady_clock::time_point;

  // Returns whether updates and jobs are refused. REQUIRES: mutex_ is held.
  bool full() const { return closing_ || commits_.size() + jobs_.size() >= options_.max_queued; }
  void Loop();
  // Takes the next job or group off its queue, and runs it without the lock. REQUIRES: a queue is
  // not empty.
  void RunFront(std::unique_lock<std::mutex>& lock);
  // Returns whether all commits before the first job have been taken from the queue. REQUIRES:
  // mutex_ is held.
  bool has_ready_job() const {
    return !jobs_.empty() && jobs_.front().commits_before <= taken_commit_count_;
  }
  void WaitForGroup(std::unique_lock<std::mutex>& lock);
  // Takes commits off the queue's front, up to the size of a group.
  std::vector<PendingCommit> TakeGroup();
  void CommitGroup(std::vector<PendingCommit> group, bool closing);
  // Commits the group, whose updates are `updates`. If one is refused, commits each half
  // separately.
  void CommitOrHalve(std::span<PendingCommit> group, std::span<const priors::SourceUpdate> updates);
  absl::Status CommitNow(std::span<const priors::SourceUpdate> updates);
  void Finish(PendingCommit& commit, const absl::Status& status);
  // Calls on_health if the cause of failing commits changed (file moved, or disk error).
  void TellHealth();
  // Calls PriorStore::CheckPlace and reports its result. `last` is true when the thread ends.
  void CheckPlace(bool last);

  std::atomic<bool> stops_changes_{false};
  const std::unique_ptr<priors::PriorStore> store_;
  const StoreThreadOptions options_;
  std::unique_ptr<ReadThread> reads_;  // may be null; destroyed before store_
  std::atomic<bool> can_write_{true};
  // The next three are used on the store's thread only.
  absl::Status place_;  // result of the latest CheckPlace; OK after a successful commit
  absl::Status disk_;   // result of the latest commit while place_ was OK
  absl::Status told_;   // argument of the latest call of on_health

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<PendingCommit> commits_;  // guarded by mutex_
  std::deque<PendingJob> jobs_;        // guarded by mutex_
  uint64_t offered_commit_count_ = 0;  // guarded by mutex_
  uint64_t taken_commit_count_ = 0;    // guarded by mutex_; commits taken from commits_ so far
  size_t queued_rows_ = 0;             // guarded by mutex_; sum of RowCount over commits_
  bool closing_ = false;               // guarded by mutex_
  priors::StoreLosses losses_;         // guarded by mutex_
  std::thread thread_;                 // the last member, because it uses the others
};

}  // namespace sweepstake::storage
