// Ends the process when its orderly end takes too long, so that a disk that never answers cannot
// keep a daemon alive that was told to end.
//
// Nothing acknowledged is lost: that is on disk, and clients send the rest again. It owns one
// thread; the destructor disarms and ends it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace sweepstake::server {

class ExitGuard {
 public:
  // After `patience` writes `message` to stderr and exits with `code`, without running destructors.
  ExitGuard(std::chrono::milliseconds patience, int code, std::string message);
  ~ExitGuard();
  ExitGuard(const ExitGuard&) = delete;
  ExitGuard& operator=(const ExitGuard&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool disarmed_ = false;  // guarded by mutex_
  std::thread thread_;     // last: starts when the rest is there
};

}  // namespace sweepstake::server
