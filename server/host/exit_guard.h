// Ends the process if its orderly end takes too long, so that a disk that never answers cannot keep
// the daemon alive.
//
// No acknowledged evidence is lost, because it is on disk, but for that of a database that is gone:
// while this is copied, the process must not end, however long it takes. Clients send the rest
// again. The guard owns one thread, which the destructor disarms and ends.
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
  // After `patience` writes `message` to stderr and exits with `code`, without running destructors.
  // If `must_wait` returns true then, on the guard's thread, the patience begins anew.
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
