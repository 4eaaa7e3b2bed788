// One thread that does a step at least every `interval`, sooner when woken.
//
// It polls because the frame thread must not make the system call that would wake it; Wake is for
// other threads (a transport's callbacks, Stop). Thread safety: every method from any thread, Start
// once.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace sweepstake {

class PollingThread {
 public:
  // The step gets true from RequestStop on, and returns whether it wants to be called again.
  using Step = std::function<bool(bool stopping)>;

  PollingThread() = default;
  // Stops and joins.
  ~PollingThread();
  PollingThread(const PollingThread&) = delete;
  PollingThread& operator=(const PollingThread&) = delete;

  void Start(std::chrono::milliseconds interval, Step step);
  void Wake();
  void RequestStop();
  // Waits for the step that returns false. Idempotent; nothing to do where Start was not called.
  void Join();

 private:
  void Run(std::chrono::milliseconds interval, const Step& step);

  std::mutex mutex_;
  std::condition_variable changed_;
  bool woken_ = false;     // guarded by mutex_
  bool stopping_ = false;  // guarded by mutex_
  std::mutex join_mutex_;  // so that two callers of Join do not join twice
  std::thread thread_;     // guarded by join_mutex_
};

}  // namespace sweepstake
