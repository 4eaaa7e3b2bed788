// Runs a prior store on its own thread and groups commits, so that one fsync serves many sessions
// and no other thread waits for it. Reads run on another thread (read_thread.h).
//
// Thread-safe. It owns the store. The destructor runs what is queued, then ends the threads. A
// commit waits at most `group_interval` for others; Close starts it at once. A job does not split a
// group: it runs after the commits that were offered before it, and after later ones of the same
// group. If a group fails because an update is refused, it is halved repeatedly, so that only that
// update fails. While closing, a failing disk is not tried again: queued commits fail at once, so
// that closing takes no longer than one commit.
//
// PriorStore::CheckPlace is called every `check_interval`, after a commit that fails, and at the
// end, even if nothing is committed.
//
// Exact reads are jobs. A loop receives a job's result after the results of all commits that the
// job has seen, and before those of all later ones. Exact reads are:
// - a session that is resumed. Its last commit may still be queued when its client comes back, and
//   a session that starts from an older state would count its messages twice, or reuse the number
//   of a commit;
// - a new session of a scene that is not stored, which counts against the quotas. A committed scene
//   must count once, there or among the scenes in memory (server/sessions/new_scenes.h);
// - the sums to which the increments of later commits are added (events/event_bus.h);
// - the quota of an import, before the import. Other reads run on the reading thread: whether a new
//   session's scene is stored and its priors, listings, exports, the audit log. Each sees some
//   state of the store that includes all that was acknowledged before the request.
//
// At Close both threads run what is queued. Commits are waited for first, so that a stuck read does
// not delay them. The reading connection ends before the store, because only the store can move the
// log into the file.
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
  // Maximum delay of an acknowledgement. A crash may lose the updates of this time.
  std::chrono::milliseconds group_interval{50};
  size_t group_rows = 500;  // a group with this many increments is committed early
  // If false there are no threads, and the owner calls RunNext and RunNextRead.
  bool own_thread = true;
  size_t max_queued = 65'536;  // updates and jobs, and reads; more are refused
  std::chrono::milliseconds max_read = ReadThreadOptions().max_read;
  std::chrono::milliseconds check_interval{2'000};
  // Called on the store's thread every `check_interval`, and at the end. May be empty.
  std::function<void(priors::PriorStore&)> on_check = {};
  // Called on the store's thread with the cause when commits begin to fail, and with OK when they
  // succeed again. NOT_FOUND is the error of PriorStore::CheckPlace, and is reported even if
  // commits fail already. If the disk still fails after that, its error is reported again.
  std::function<void(const absl::Status&)> on_health = [](const absl::Status&) {};
  // Called on the store's thread after `on_health`, at each check that returns NOT_FOUND. It may
  // save the store elsewhere. `last` is true at the check at the end, the last call. May be empty.
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
  // Without a reading connection, reads are jobs.
  explicit StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options = {},
                       std::unique_ptr<ReadConnection> reads = nullptr);
  ~StoreThread() override;
  // Runs what is queued and ends the threads. Later commits, jobs and reads are refused. May be
  // called again, by one thread at a time.
  void Close();
  StoreThread(const StoreThread&) = delete;
  StoreThread& operator=(const StoreThread&) = delete;

  void Commit(priors::SourceUpdate update, CommitCallback done) override;
  bool Submit(Job job) override;
  bool Read(ReadJob job) override;
  bool healthy() const override { return can_write() && can_read(); }
  bool can_write() const { return can_write_.load(std::memory_order_relaxed); }
  // Returns false while a read takes longer than max_read.
  bool can_read() const { return reads_ == nullptr || !reads_->stuck(); }
  // Runs the next job that waits for no commit, or the next group of commits. Returns false if
  // nothing is queued. REQUIRES: own_thread is false.
  bool RunNext();
  bool RunNextRead() { return reads_ != nullptr && reads_->RunNext(); }
  // Returns the number of waiting updates and jobs.
  size_t queued_count() const;
  size_t queued_read_count() const { return reads_ == nullptr ? 0 : reads_->queued_count(); }
  uint64_t lost_audit_row_count() const override {
    return lost_audit_row_count_.load(std::memory_order_relaxed);
  }

 private:
  struct PendingCommit {
    priors::SourceUpdate update;
    CommitCallback done;
  };
  struct PendingJob {
    Job run;
    uint64_t commits_before = 0;  // commits that were offered before it
  };
  using TimePoint = std::chrono::steady_clock::time_point;

  // Whether updates and jobs are refused. REQUIRES: mutex_ is held.
  bool full() const { return closing_ || commits_.size() + jobs_.size() >= options_.max_queued; }
  void Loop();
  // Takes the next job or group off its queue, and runs it without the lock. REQUIRES: a queue is
  // not empty.
  void RunFront(std::unique_lock<std::mutex>& lock);
  // Whether the first job waits for no commit. REQUIRES: mutex_ is held.
  bool has_ready_job() const {
    return !jobs_.empty() && jobs_.front().commits_before <= taken_commit_count_;
  }
  void WaitForGroup(std::unique_lock<std::mutex>& lock);
  // Takes commits off the queue's front, up to the size of a group.
  std::vector<PendingCommit> TakeGroup();
  void CommitGroup(std::vector<PendingCommit> group, bool closing);
  // `updates` are those of the group.
  void CommitOrHalve(std::span<PendingCommit> group, std::span<const priors::SourceUpdate> updates);
  absl::Status CommitNow(std::span<const priors::SourceUpdate> updates);
  void Finish(PendingCommit& commit, const absl::Status& status);
  // Calls on_health if the cause of failing commits changed (file moved, or disk error).
  void TellHealth();
  // `last`: the check at the end.
  void CheckPlace(bool last);

  const std::unique_ptr<priors::PriorStore> store_;
  const StoreThreadOptions options_;
  std::unique_ptr<ReadThread> reads_;  // may be null; ends before the store
  std::atomic<bool> can_write_{true};
  // Used on the store's thread.
  absl::Status place_;  // of the latest check, or of a commit that succeeded since
  absl::Status disk_;   // of the latest commit, if the place was right
  absl::Status told_;   // of the latest call of on_health
  std::atomic<uint64_t> lost_audit_row_count_{0};  // the store's, after the latest commit

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<PendingCommit> commits_;  // guarded by mutex_
  std::deque<PendingJob> jobs_;        // guarded by mutex_
  uint64_t offered_commit_count_ = 0;  // guarded by mutex_
  uint64_t taken_commit_count_ = 0;    // guarded by mutex_; those that left commits_
  size_t queued_rows_ = 0;             // guarded by mutex_; of the commits in the queue
  bool closing_ = false;               // guarded by mutex_
  std::thread thread_;                 // the last member, because it uses the others
};

}  // namespace sweepstake::storage
