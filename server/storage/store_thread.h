// Runs a prior store on its own thread and groups commits, so that one fsync serves many sessions
// and no other thread waits for it. What only reads runs beside it, on another (read_thread.h).
//
// Thread-safe. It owns the store; the destructor runs what is queued, then ends the threads. A
// commit waits at most `group_interval` for others, and is started at once by Close. Jobs do not
// cut a group: one runs when the commits that were offered before it are done, later ones of their
// group included. If a group fails because of an update that is refused, its halves are committed
// by themselves, and theirs, so that only that one is. While closing, a disk that fails is not
// tried again: what is still queued fails at once, so that closing takes no longer than one commit.
//
// Every `check_interval`, after a commit that fails, and at the end the store is asked whether what
// it commits would be lost (PriorStore::CheckPlace), whether anything is committed or not.
//
// What must be exact is read by a job. A loop gets the job's result, if it comes the same way as
// the news of the commits, behind those of all that the job has seen and before those of all later
// ones:
// - a session that is resumed. Its last commit may still be queued when its client comes back,
//   and one that began from an older state would count its messages twice, or give its next commit
//   a number that is taken;
// - a fresh session of a scene that is not stored, which counts against the quotas: what was
//   committed must count once, there or among the scenes in memory (server/sessions/new_scenes.h);
// - the sums to which the increments of later commits are added (watch/watch_hub.h);
// - the quota of an import, which the import itself follows.
// The rest is read beside: whether a fresh session's scene is stored and what it begins from then,
// listings, exports, the audit log. Each is some state of the store that has all that was
// acknowledged before the request.
//
// Closing: both threads run what they have. Commits are waited for first, so that a read that
// hangs holds up none; the connection that reads ends before the store, which alone can put the
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
  // The maximum delay of an acknowledgement, and the time whose updates a crash may lose.
  std::chrono::milliseconds group_interval{50};
  size_t group_rows = 500;  // a group with this many increments is committed early
  // If false there are no threads: the owner calls RunNext and RunNextRead.
  bool own_thread = true;
  size_t max_queued = 65'536;  // updates and jobs; beyond it they are refused, as are reads
  std::chrono::milliseconds max_read = ReadThreadOptions().max_read;
  std::chrono::milliseconds check_interval{2'000};
  // Called on the store's thread every `check_interval`, and at the end. May be empty.
  std::function<void(priors::PriorStore&)> on_check = {};
  // Is told, on the store's thread, that commits begin to fail and why, and with OK that they
  // succeed again. NOT_FOUND is that of PriorStore::CheckPlace, and is told whether commits fail
  // already or not; when that is over and the disk failed too, the disk's error is told again.
  std::function<void(const absl::Status&)> on_health = [](const absl::Status&) {};
  // Called on the store's thread at each check that says NOT_FOUND, behind `on_health`: may keep
  // what the store has elsewhere. No other call comes behind the `last`, that of the check at the
  // end. May be empty.
  std::function<void(priors::PriorStore&, bool last)> on_misplaced = {};
  // Told on the store's thread of each update that can never be stored, and why.
  std::function<void(const priors::SourceUpdate&, const absl::Status&)> on_refusal = {};
  // Told on the store's thread how long each commit of the store took. May be empty.
  std::function<void(std::chrono::nanoseconds)> on_commit = {};
  // ReadThreadOptions::on_read.
  std::function<void(std::chrono::nanoseconds)> on_read = {};
};

class StoreThread final : public priors::AsyncPriorStore {
 public:
  // Without a connection that reads, reads are jobs.
  explicit StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options = {},
                       std::unique_ptr<ReadConnection> reads = nullptr);
  ~StoreThread() override;
  // Runs what is queued and ends the threads; later commits, jobs and reads are refused. It may be
  // called again, by one thread at a time.
  void Close();
  StoreThread(const StoreThread&) = delete;
  StoreThread& operator=(const StoreThread&) = delete;

  void Commit(priors::SourceUpdate update, CommitCallback done) override;
  bool Submit(Job job) override;
  bool Read(ReadJob job) override;
  bool healthy() const override { return can_write() && can_read(); }
  bool can_write() const { return can_write_.load(std::memory_order_relaxed); }
  // Returns false while a read takes longer than it may.
  bool can_read() const { return reads_ == nullptr || !reads_->stuck(); }
  // Runs the next job that waits for no commit, or the next group of commits. Returns false if
  // nothing is queued. REQUIRES: there is no own thread.
  bool RunNext();
  bool RunNextRead() { return reads_ != nullptr && reads_->RunNext(); }
  // Returns how many updates and jobs wait.
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

  // Whether nothing more is taken. REQUIRES: mutex_ is held.
  bool full() const { return closing_ || commits_.size() + jobs_.size() >= options_.max_queued; }
  void Loop();
  // Takes the next job or group off its queue, and runs it without the lock. REQUIRES: one queue is
  // not empty.
  void RunFront(std::unique_lock<std::mutex>& lock);
  // Whether the first job waits for no commit. REQUIRES: mutex_ is held.
  bool has_ready_job() const {
    return !jobs_.empty() && jobs_.front().commits_before <= taken_commit_count_;
  }
  void WaitForGroup(std::unique_lock<std::mutex>& lock);
  // Takes commits off the queue's front, as many as a group may have.
  std::vector<PendingCommit> TakeGroup();
  void CommitGroup(std::vector<PendingCommit> group, bool closing);
  // `updates` are those of the group.
  void CommitOrHalve(std::span<PendingCommit> group, std::span<const priors::SourceUpdate> updates);
  absl::Status CommitNow(std::span<const priors::SourceUpdate> updates);
  void Finish(PendingCommit& commit, const absl::Status& status);
  // Tells of a change of what commits are kept by: by the place, else by the disk.
  void TellHealth();
  // `last`: at the end.
  void CheckPlace(bool last);

  const std::unique_ptr<priors::PriorStore> store_;
  const StoreThreadOptions options_;
  std::unique_ptr<ReadThread> reads_;  // may be null; ends before the store
  std::atomic<bool> can_write_{true};
  // These are used on the store's thread.
  absl::Status place_;  // said the latest check, or the commit that succeeded since
  absl::Status disk_;   // said the latest commit that was not kept by the place
  absl::Status told_;   // was told last
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
