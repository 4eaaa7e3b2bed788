#include "server/storage/store_thread.h"

#include <sys/resource.h>

#include <utility>

namespace sweepstake::storage {
namespace {

// The `nice` value of the store's thread. A commit can take milliseconds of processor time. If all
// processors are busy, the threads that answer games go first: acknowledgements can wait, decisions
// cannot.
constexpr int kNiceness = 10;

// Returns the number of rows that an update writes: its own and one per increment.
size_t RowCount(const priors::SourceUpdate& update) { return 1 + update.increments.size(); }

}  // namespace

StoreThread::StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options,
                         std::unique_ptr<ReadConnection> reads)
    : store_(std::move(store)), options_(std::move(options)) {
  store_->StopChangesWhen(stops_changes_);
  if (reads != nullptr) {
    reads_ = std::make_unique<ReadThread>(std::move(reads),
                                          ReadThreadOptions{.own_thread = options_.own_thread,
                                                            .max_queued = options_.max_queued,
                                                            .max_read = options_.max_read,
                                                            .on_read = options_.on_read});
  }
  if (options_.own_thread) thread_ = std::thread([this] { Loop(); });
}

StoreThread::~StoreThread() { Close(); }

void StoreThread::Close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  if (reads_ != nullptr) reads_->Close();
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (!options_.own_thread) {
    while (RunNext()) continue;
  }
  if (reads_ != nullptr) reads_->Join();
}

void StoreThread::Commit(priors::SourceUpdate update, CommitCallback done) {
  {
    const std::lock_guard lock(mutex_);
    if (!full()) {
      queued_rows_ += RowCount(update);
      ++offered_commit_count_;
      commits_.push_back({std::move(update), std::exchange(done, nullptr)});
    }
  }
  if (done == nullptr) return changed_.notify_all();
  done(absl::ResourceExhaustedError(
      "the queue of the prior store is full or closed; try again later"));
}

bool StoreThread::Submit(Job job) {
  {
    const std::lock_guard lock(mutex_);
    if (full()) return false;
    jobs_.push_back({std::move(job), offered_commit_count_});
  }
  changed_.notify_all();
  return true;
}

bool StoreThread::Read(ReadJob job) {
  return reads_ != nullptr ? reads_->Submit(std::move(job)) : Submit(std::move(job));
}

void StoreThread::WaitForGroup(std::unique_lock<std::mutex>& lock) {
  const TimePoint deadline = std::chrono::steady_clock::now() + options_.group_interval;
  changed_.wait_until(lock, deadline, [&] {
    return closing_ || has_ready_job() || queued_rows_ >= options_.group_rows;
  });
}

std::vector<StoreThread::PendingCommit> StoreThread::TakeGroup() {
  std::vector<PendingCommit> group;
  size_t rows = 0;
  while (!commits_.empty() && rows < options_.group_rows) {
    rows += RowCount(commits_.front().update);
    group.push_back(std::move(commits_.front()));
    commits_.pop_front();
  }
  queued_rows_ -= rows;
  taken_commit_count_ += group.size();
  return group;
}

void StoreThread::Loop() {
  setpriority(PRIO_PROCESS, 0, kNiceness);  // on Linux, changes only this thread
  std::unique_lock lock(mutex_);
  TimePoint next_check = std::chrono::steady_clock::now() + options_.check_interval;
  while (true) {
    changed_.wait_until(lock, next_check,
                        [&] { return closing_ || !commits_.empty() || !jobs_.empty(); });
    const bool idle = commits_.empty() && jobs_.empty();
    const bool ends = idle && closing_;
    if (!idle) {
      if (!has_ready_job()) WaitForGroup(lock);
      RunFront(lock);
    } else {
      lock.unlock();
    }
    if (ends || std::chrono::steady_clock::now() >= next_check) {
      CheckPlace(ends);
      if (options_.on_check) options_.on_check(*store_);
      next_check = std::chrono::steady_clock::now() + options_.check_interval;
    }
    if (ends) return;
    lock.lock();
  }
}

bool StoreThread::RunNext() {
  std::unique_lock lock(mutex_);
  if (commits_.empty() && jobs_.empty()) return false;
  RunFront(lock);
  return true;
}

size_t StoreThread::queued_count() const {
  const std::lock_guard lock(mutex_);
  return commits_.size() + jobs_.size();
}

void StoreThread::RunFront(std::unique_lock<std::mutex>& lock) {
  if (has_ready_job()) {
    const Job job = std::move(jobs_.front().run);
    jobs_.pop_front();
    lock.unlock();
    job(*store_);
  } else {
    std::vector<PendingCommit> group = TakeGroup();
    const bool closing = closing_;
    lock.unlock();
    CommitGroup(std::move(group), closing);
  }
}

void StoreThread::CommitGroup(std::vector<PendingCommit> group, bool closing) {
  if (closing && !can_write()) {
    const absl::Status status =
        absl::UnavailableError("the prior store is closing; nothing more can be written");
    for (PendingCommit& commit : group) commit.done(status);
    return;
  }
  std::vector<priors::SourceUpdate> updates;
  updates.reserve(group.size());
  for (const PendingCommit& commit : group) updates.push_back(commit.update);
  CommitOrHalve(group, updates);
}

void StoreThread::CommitOrHalve(std::span<PendingCommit> group,
                                std::span<const priors::SourceUpdate> updates) {
  const absl::Status status = CommitNow(updates);
  if (priors::IsRefusal(status) && group.size() > 1) {
    const size_t half = group.size() / 2;
    CommitOrHalve(group.first(half), updates.first(half));
    return CommitOrHalve(group.subspan(half), updates.subspan(half));
  }
  // Checks first whether the file was removed or replaced. Finish then reports no disk error.
  if (absl::IsUnavailable(status)) CheckPlace(/*last=*/false);
  for (PendingCommit& commit : group) Finish(commit, status);
}

absl::Status StoreThread::CommitNow(std::span<const priors::SourceUpdate> updates) {
  const TimePoint start = std::chrono::steady_clock::now();
  absl::Status status = store_->Commit(updates);
  if (reads_ != nullptr) reads_->OnCommitted();
  if (options_.on_commit) options_.on_commit(std::chrono::steady_clock::now() - start);
  const std::lock_guard lock(mutex_);
  losses_ = store_->losses();
  return status;
}

priors::StoreLosses StoreThread::losses() const {
  const std::lock_guard lock(mutex_);
  return losses_;
}

void StoreThread::Finish(PendingCommit& commit, const absl::Status& status) {
  // A refused update does not show that the disk fails.
  if (priors::IsRefusal(status)) {
    if (options_.on_refusal) options_.on_refusal(commit.update, status);
  } else {
    // A successful commit shows that the file is at its path. A failed commit shows a disk error
    // only if the file is at its path.
    if (status.ok()) place_ = absl::OkStatus();
    if (place_.ok()) disk_ = status;
    TellHealth();
  }
  commit.done(status);
}

void StoreThread::TellHealth() {
  const absl::Status& status = place_.ok() ? disk_ : place_;
  if (status.ok() == told_.ok() && absl::IsNotFound(status) == absl::IsNotFound(told_)) return;
  told_ = status;
  // on_health is called before can_write_ changes, so that observers of healthy() find the cause.
  options_.on_health(status);
  can_write_ = status.ok();
}

void StoreThread::CheckPlace(bool last) {
  const absl::Status status = store_->CheckPlace();
  // After another error, the next commit shows whether the disk works.
  if (!status.ok() && !absl::IsNotFound(status)) return;
  place_ = status;
  TellHealth();
  if (!place_.ok() && options_.on_misplaced) options_.on_misplaced(*store_, last);
}

}  // namespace sweepstake::storage
