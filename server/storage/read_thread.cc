#include "server/storage/read_thread.h"

#include <utility>

namespace sweepstake::storage {

using std::chrono::steady_clock;

ReadThread::ReadThread(std::unique_ptr<ReadConnection> connection, ReadThreadOptions options)
    : connection_(std::move(connection)), options_(std::move(options)) {
  if (options_.own_thread) thread_ = std::thread([this] { Loop(); });
}

ReadThread::~ReadThread() {
  Close();
  Join();
}

bool ReadThread::Submit(Job job) {
  {
    const std::lock_guard lock(mutex_);
    if (closing_ || queue_.size() >= options_.max_queued) return false;
    queue_.push_back({std::move(job), steady_clock::now()});
  }
  changed_.notify_all();
  return true;
}

void ReadThread::Close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
}

void ReadThread::Join() {
  if (thread_.joinable()) thread_.join();
  if (!options_.own_thread) {
    while (RunNext()) continue;
  }
  connection_.reset();
}

void ReadThread::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return closing_ || !queue_.empty(); });
    if (queue_.empty()) return;
    GiveWay(lock);
    RunFront(lock);
    lock.lock();
  }
}

void ReadThread::GiveWay(std::unique_lock<std::mutex>& lock) {
  const auto gone = [&] {
    return closing_ || crowded_commit_count_ < options_.max_crowded_commits;
  };
  if (gone()) return;
  changed_.wait_for(lock, options_.pause, gone);
  crowded_commit_count_ = 0;
}

bool ReadThread::RunNext() {
  std::unique_lock lock(mutex_);
  if (queue_.empty()) return false;
  RunFront(lock);
  return true;
}

void ReadThread::RunFront(std::unique_lock<std::mutex>& lock) {
  const Waiting next = std::move(queue_.front());
  queue_.pop_front();
  reading_ = steady_clock::now();
  read_since_commit_ = true;
  lock.unlock();
  next.job(connection_->Begin());
  connection_->End();
  if (options_.on_read) options_.on_read(steady_clock::now() - next.since);
  lock.lock();
  reading_.reset();
  lock.unlock();
}

void ReadThread::OnCommitted() {
  {
    const std::lock_guard lock(mutex_);
    crowded_commit_count_ = read_since_commit_ ? crowded_commit_count_ + 1 : 0;
    read_since_commit_ = reading_.has_value();
  }
  changed_.notify_all();
}

size_t ReadThread::queued_count() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

bool ReadThread::stuck() const {
  const std::lock_guard lock(mutex_);
  return reading_ && steady_clock::now() - *reading_ >= options_.max_read;
}

}  // namespace sweepstake::storage
