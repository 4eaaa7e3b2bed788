// Runs the reads of a store on a thread and a connection of their own, so that commits do not wait
// for them.
//
// - A read is one job, and sees one state of the store. Long answers are read page by page, with a
//   job for each.
// - SQLite's write-ahead log grows while reads run, because SQLite restarts the log only at a
//   commit during which no read runs. After `max_crowded_commits` commits in a row that each had a
//   read since the previous commit, the next read waits. It begins after a commit without a read,
//   or after `pause`. Commits never wait.
// - A read that does not end blocks the reads behind it, and nothing else. stuck() detects it.
//
// Thread-safe. Owns the connection. The destructor runs the queued jobs, ends the thread, and
// closes the connection, in this order.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

// A second connection to the store's database, which only reads. Used by one thread.
class ReadConnection {
 public:
  virtual ~ReadConnection() = default;

  // All reads until End see one state of the store: the state at the first read.
  virtual priors::PriorReader& Begin() = 0;
  virtual void End() = 0;
};

struct ReadThreadOptions {
  bool own_thread = true;  // if false, the owner calls RunNext, and reads never wait for commits
  size_t max_queued = 65'536;                  // further jobs are refused
  std::chrono::milliseconds max_read{10'000};  // a read that takes longer is stuck
  uint32_t max_crowded_commits = 256;
  std::chrono::milliseconds pause{500};
  // Called on the reading thread with the duration of each read, including its time in the queue.
  // May be empty.
  std::function<void(std::chrono::nanoseconds)> on_read = {};
};

class ReadThread {
 public:
  using Job = priors::AsyncPriorStore::ReadJob;

  ReadThread(std::unique_ptr<ReadConnection> connection, ReadThreadOptions options);
  ~ReadThread();
  ReadThread(const ReadThread&) = delete;
  ReadThread& operator=(const ReadThread&) = delete;

  // Returns false if the queue is full or closed.
  bool Submit(Job job);
  // Refuses further jobs and does not wait. Queued jobs still run.
  void Close();
  // Waits for the last job after Close, and ends the connection.
  void Join();
  // Runs the next job. Returns false if none is queued. REQUIRES: own_thread is false.
  bool RunNext();
  // The thread that commits must call this after each commit.
  void OnCommitted();

  size_t queued_count() const;
  // Returns whether the current read takes longer than max_read.
  bool stuck() const;

 private:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Waiting {
    Job job;
    TimePoint since;
  };

  void Loop();
  void GiveWay(std::unique_lock<std::mutex>& lock);
  // Takes the first job and runs it without the lock. REQUIRES: the queue is not empty.
  void RunFront(std::unique_lock<std::mutex>& lock);

  std::unique_ptr<ReadConnection> connection_;
  const ReadThreadOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> queue_;         // guarded by mutex_
  bool closing_ = false;              // guarded by mutex_
  std::optional<TimePoint> reading_;  // guarded by mutex_; start of the running read
  bool read_since_commit_ = false;    // guarded by mutex_
  // Guarded by mutex_. Number of latest commits in a row with a read since the previous commit.
  uint32_t crowded_commit_count_ = 0;
  std::thread thread_;  // the last member, because it uses the others
};

}  // namespace sweepstake::storage
