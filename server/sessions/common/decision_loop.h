// The decision loop, which is the thread that runs all sessions, and its clock.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace sweepstake::sessions {

// The clock of the decision loop. It returns the time and waits for a time. Tests replace it.
//
// Times are nanoseconds since an arbitrary moment. They never decrease, even if the wall clock is
// set back. NowNs and Wake may be called from any thread, WaitUntil from one.
class LoopClock {
 public:
  static constexpr int64_t kNever = INT64_MAX;

  virtual ~LoopClock() = default;
  virtual int64_t NowNs() const = 0;
  // Returns when NowNs() >= deadline_ns or Wake was called since the last return. It may also
  // return earlier.
  virtual void WaitUntil(int64_t deadline_ns) = 0;
  virtual void Wake() = 0;
};

// The clock of the daemon: std::chrono::steady_clock.
class SteadyLoopClock final : public LoopClock {
 public:
  int64_t NowNs() const override;
  void WaitUntil(int64_t deadline_ns) override;
  void Wake() override;

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
  bool wake_ = false;  // guarded by mutex_
};

// The one thread that runs the sessions and makes their decisions.
//
// The callbacks of the transport and of the store only post tasks here. Sessions therefore need no
// locks, and no other thread waits for a decision. Post, PostLater and PostAt are thread-safe.
//
// Tasks run in the order of posting, PostAt tasks when they are due. In each turn, the loop runs
// all Post tasks, but only a few PostLater and PostAt tasks. A message with frames (Post) therefore
// does not wait for the results of a thousand commits (PostLater). Tasks must not wait and must not
// throw. The queues are bounded, because each stream, watcher and commit has at most a few tasks in
// them. The destructor runs the posted tasks, drops tasks that are not due yet, and ends the
// thread. The clock must outlive the loop.
class DecisionLoop {
 public:
  using Task = std::function<void()>;
  using OnTimer = std::function<void(std::chrono::nanoseconds lateness)>;

  enum class Runner {
    kOwnThread,
    kCaller,  // RunReady runs the tasks; the destructor drops the remaining ones
  };

  // `on_timer`, if set, is called on the loop's thread with the lateness of each PostAt task.
  explicit DecisionLoop(LoopClock& clock, OnTimer on_timer = {},
                        Runner runner = Runner::kOwnThread);
  ~DecisionLoop();
  DecisionLoop(const DecisionLoop&) = delete;
  DecisionLoop& operator=(const DecisionLoop&) = delete;

  void Post(Task task);
  // Like Post, but tasks of Post may overtake this one.
  void PostLater(Task task);
  // Runs `task` once the clock has reached `due_ns`.
  void PostAt(int64_t due_ns, Task task);
  // Runs all tasks that are posted or due, and the tasks that these post. Returns the time at which
  // the next PostAt task is due, or Clock::kNever. REQUIRES: Runner::kCaller.
  int64_t RunReady();

  LoopClock& clock() { return clock_; }

 private:
  using Timers = std::multimap<int64_t, Task>;

  // The tasks of one turn: the loop collects them together and runs them before it collects again.
  struct Turn {
    std::vector<Task> ready;
    Timers due;
    int64_t next_due_ns = LoopClock::kNever;

    bool empty() const { return ready.empty() && due.empty(); }
  };

  void Run();
  template <typename Queue>
  void Put(Queue& queue, Task task);
  // Moves all Post tasks into the turn, and a few of the PostLater and the due PostAt tasks.
  // Returns false if the loop is closing and no task is left.
  bool Collect(Turn& turn);
  void RunTasks(Turn& turn);

  LoopClock& clock_;
  const OnTimer on_timer_;
  std::mutex mutex_;
  std::vector<Task> posted_;  // guarded by mutex_
  std::deque<Task> later_;    // guarded by mutex_
  Timers timers_;             // guarded by mutex_
  bool closing_ = false;      // guarded by mutex_
  std::thread thread_;  // last: it uses the members above; not started if the caller is the runner
};

}  // namespace sweepstake::sessions
