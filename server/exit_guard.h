// Ends the process when its orderly end takes too long: a disk that never answers must not keep a
// daemon that was told to go.
//
// Nothing acknowledged is lost by it: that is on disk, and clients send the rest again. Owns one
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
