// The one thread on which sessions live and decisions are taken.
//
// gRPC's reactions and the store's callbacks only post here, so that sessions need no locks and
// nothing waits for a decision. Post and PostAt are thread-safe. Tasks run in the order of posting,
// those of PostAt when due; they must not wait and must not throw. The queue is bounded by its
// posters: each stream, watcher and commit has at most a few tasks in it. The destructor runs what
// was posted, drops what is not due yet, and ends the thread; the clock must outlive it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "server/rpc/clock.h"

namespace sweepstake::rpc {

class DecisionLoop {
 public:
  using Task = std::function<void()>;

  explicit DecisionLoop(Clock& clock);
  ~DecisionLoop();
  DecisionLoop(const DecisionLoop&) = delete;
  DecisionLoop& operator=(const DecisionLoop&) = delete;

  void Post(Task task);
  // Runs `task` once the clock has reached `due_ns`.
  void PostAt(int64_t due_ns, Task task);

  Clock& clock() { return clock_; }

 private:
  void Run();
  // Moves what is to run now into `ready`; false: closing and nothing is left.
  bool Collect(std::vector<Task>& ready, int64_t& next_due_ns);

  Clock& clock_;
  std::mutex mutex_;
  std::vector<Task> posted_;             // guarded by mutex_
  std::multimap<int64_t, Task> timers_;  // guarded by mutex_
  bool closing_ = false;                 // guarded by mutex_
  std::thread thread_;                   // last: starts when the rest is there
};

}  // namespace sweepstake::rpc
