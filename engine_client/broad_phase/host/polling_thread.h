// A thread that runs a step after each pause, or earlier if Wake is called.
//
// The thread polls, because the frame thread must not make the system call that would wake it. Wake
// is for other threads, such as a transport's callbacks. A forked child does not have the thread;
// there all functions do nothing. Thread safety: every method on any
// thread; Start only once.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/host/thread_owned.h"

namespace sweepstake {

class PollingThread {
 public:
  // Runs one step. `stopping` is true after RequestStop. Returns the pause before the next step, or
  // nothing to end the thread.
  using Step = std::function<std::optional<std::chrono::microseconds>(bool stopping)>;

  // `name` is a literal of at most 15 characters.
  explicit PollingThread(const char* name, ThreadPriority priority = ThreadPriority::kOfTheStarter);
  // Calls RequestStop and Join.
  ~PollingThread();
  PollingThread(const PollingThread&) = delete;
  PollingThread& operator=(const PollingThread&) = delete;

  // Starts the thread; the first step runs after `pause`. Throws std::system_error if the system
  // has no more threads.
  void Start(std::chrono::microseconds pause, Step step);
  void Wake();
  void RequestStop();
  // Waits until the thread has ended, because a step returned nothing. May be called several times.
  // Returns at once if Start was not called.
  void Join();
  bool is_in_child() const { return state_.get_deleter().is_in_child(); }

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool woken = false;     // guarded by mutex
    bool stopping = false;  // guarded by mutex
    std::mutex join_mutex;  // so that only one caller of Join joins the thread
    std::thread thread;     // guarded by join_mutex
  };

  void Run(std::chrono::microseconds pause, const Step& step);

  const char* const name_;
  const ThreadPriority priority_;
  const ThreadOwned<State> state_ = MakeThreadOwned<State>();
};

}  // namespace sweepstake
