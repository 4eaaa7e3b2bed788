#include "server/storage/store_thread.h"

#include <algorithm>
#include <utility>

namespace sweepstake::storage {
namespace {

// Returns the number of rows that an update writes: its own and one per increment.
size_t RowCount(const priors::SourceUpdate& update) { return 1 + update.increments.size(); }

}  // namespace

StoreThread::StoreThread(std::unique_ptr<priors::PriorStore> store, StoreThreadOptions options)
    : store_(std::move(store)), options_(std::move(options)) {
  if (options_.own_thread) thread_ = std::thread([this] { Loop(); });
}

StoreThread::~StoreThread() { Close(); }

void StoreThread::Close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (!options_.own_thread) {
    while (RunNext()) continue;
  }
}

bool StoreThread::Enqueue(Item item, size_t rows) {
  {
    const std::lock_guard lock(mutex_);
    if (closing_ || queue_.size() >= options_.max_queued) return false;
    queued_rows_ += rows;
    queued_jobs_ += std::holds_alternative<Job>(item) ? 1 : 0;
    queue_.push_back(std::move(item));
  }
  changed_.notify_all();
  return true;
}

void StoreThread::Commit(priors::SourceUpdate update, CommitCallback done) {
  const size_t rows = RowCount(update);
  CommitCallback refused = done;
  if (!Enqueue(PendingCommit{std::move(update), std::move(done)}, rows)) {
    refused(absl::ResourceExhaustedError(
        "the queue of the prior store is full or closed; offer the update again later"));
  }
}

bool StoreThread::Submit(Job job) { return Enqueue(std::move(job), 0); }

void StoreThread::WaitForGroup(std::unique_lock<std::mutex>& lock) {
  const TimePoint deadline = std::chrono::steady_clock::now() + options_.group_interval;
  changed_.wait_until(lock, deadline, [&] {
    return closing_ || queued_jobs_ > 0 || queued_rows_ >= options_.group_rows;
  });
}

std::vector<StoreThread::PendingCommit> StoreThread::TakeGroup() {
  std::vector<PendingCommit> group;
  size_t rows = 0;
  while (!queue_.empty() && rows < options_.group_rows) {
    auto* commit = std::get_if<PendingCommit>(&queue_.front());
    if (commit == nullptr) break;
    rows += RowCount(commit->update);
    group.push_back(std::move(*commit));
    queue_.pop_front();
  }
  queued_rows_ -= rows;
  return group;
}

void StoreThread::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return closing_ || !queue_.empty(); });
    if (queue_.empty()) return;
    if (std::holds_alternative<PendingCommit>(queue_.front())) WaitForGroup(lock);
    RunFront(lock);
    lock.lock();
  }
}

bool StoreThread::RunNext() {
  std::unique_lock lock(mutex_);
  if (queue_.empty()) return false;
  RunFront(lock);
  return true;
}

size_t StoreThread::queued_count() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

void StoreThread::RunFront(std::unique_lock<std::mutex>& lock) {
  if (std::holds_alternative<Job>(queue_.front())) {
    Job job = std::get<Job>(std::move(queue_.front()));
    queue_.pop_front();
    --queued_jobs_;
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
  if (closing && !healthy()) {
    const absl::Status status = absl::UnavailableError("the prior store closes, and cannot write");
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
  if (absl::IsInvalidArgument(status) && group.size() > 1) {
    const size_t half = group.size() / 2;
    CommitOrHalve(group.first(half), updates.first(half));
    return CommitOrHalve(group.subspan(half), updates.subspan(half));
  }
  for (PendingCommit& commit : group) Finish(commit, status);
}

absl::Status StoreThread::CommitNow(std::span<const priors::SourceUpdate> updates) {
  const TimePoint start = std::chrono::steady_clock::now();
  absl::Status status = store_->Commit(updates);
  if (options_.on_commit) options_.on_commit(std::chrono::steady_clock::now() - start);
  return status;
}

void StoreThread::Finish(PendingCommit& commit, const absl::Status& status) {
  // An invalid update says nothing about the disk.
  if (absl::IsInvalidArgument(status)) {
    if (options_.on_refusal) options_.on_refusal(commit.update, status);
  } else if (healthy_ != status.ok()) {
    options_.on_health(status);  // first, so that whoever sees that it is not healthy finds out why
    healthy_ = status.ok();
  }
  lost_audit_row_count_.store(store_->lost_audit_row_count(), std::memory_order_relaxed);
  commit.done(status);
}

}  // namespace sweepstake::storage
