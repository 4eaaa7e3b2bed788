// Runs the reads of a store on a thread and a connection of their own, so that no commit waits for
// one.
//
// - A read is one job, and what it reads is one state of the store. Long answers are read page by
//   page, a job each.
// - What is committed gathers in the write-ahead log while states are being read, and only a commit
//   that meets no read lets the log begin anew. Where reads follow one another without a pause, the
//   next one therefore waits, once `max_crowded_commits` have met one, until a commit has met none;
//   at most for `pause`, since without commits the log does not grow. Commits never wait.
// - A read that does not come to its end holds up those behind it, and nothing else. stuck() tells
//   it.
//
// Thread-safe. It owns the connection; the destructor runs what is queued, and then ends the thread
// and the connection, in this order.
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

// A connection that reads beside the one that writes. Used by one thread.
class ReadConnection {
 public:
  virtual ~ReadConnection() = default;

  // Until End, all that is read is one state of the store, as it is at the first read.
  virtual priors::PriorReader& Begin() = 0;
  virtual void End() = 0;
};

struct ReadThreadOptions {
  bool own_thread = true;      // if false the owner calls RunNext, and nothing pauses
  size_t max_queued = 65'536;  // further jobs are refused
  std::chrono::milliseconds max_read{10'000};  // a read that takes longer is stuck
  uint32_t max_crowded_commits = 32;
  std::chrono::milliseconds pause{500};
  // Told on the reading thread how long each read took, its time in the queue included. May be
  // empty.
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
  // Refuses further jobs; does not wait. Those in the queue run.
  void Close();
  // Waits for the last job after Close, and ends the connection.
  void Join();
  // Runs the next job. Returns false if none is queued. REQUIRES: there is no own thread.
  bool RunNext();
  // To be called after each commit, by the thread that commits.
  void OnCommitted();

  size_t queued_count() const;
  // Returns whether the present read takes longer than it may.
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
  std::deque<Waiting> queue_;          // guarded by mutex_
  bool closing_ = false;               // guarded by mutex_
  std::optional<TimePoint> reading_;   // guarded by mutex_; since when a read runs
  bool read_since_commit_ = false;     // guarded by mutex_
  uint32_t crowded_commit_count_ = 0;  // guarded by mutex_; those in a row that met a read
  std::thread thread_;                 // the last member, because it uses the others
};

}  // namespace sweepstake::storage
