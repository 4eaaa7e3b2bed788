// Exits the process if its orderly end takes too long, for instance because a disk does not answer.
//
// An early exit loses no evidence: acknowledged evidence is on disk, and clients send the rest
// again. The exception is a database whose file was removed. The process must not exit while that
// database is copied (`must_wait`). The guard owns one thread, which the destructor stops.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace sweepstake::server {

class ExitGuard {
 public:
  // After `patience`, writes `message` to stderr and exits with `code`, without running
  // destructors. While `must_wait` returns true, waits for `patience` again instead. Calls
  // `must_wait` on the guard's thread.
  ExitGuard(std::chrono::milliseconds patience, int code, std::string message,
            std::function<bool()> must_wait);
  ~ExitGuard();
  ExitGuard(const ExitGuard&) = delete;
  ExitGuard& operator=(const ExitGuard&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool disarmed_ = false;  // guarded by mutex_
  std::thread thread_;     // last: it uses the members above
};

}  // namespace sweepstake::server
