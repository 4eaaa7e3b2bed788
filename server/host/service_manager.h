// What the daemon tells the service manager that started it: systemd, or another that sets
// NOTIFY_SOCKET. Nobody is told anything where nothing is set.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace sweepstake::server {

void NotifyReady();
void NotifyStopping();
// The end takes up to `time` from now, however long it may.
void NotifyStoppingTakes(std::chrono::microseconds time);

// Returns how often the service manager wants to hear that the daemon is alive: a quarter of the
// time in WATCHDOG_USEC, after which it restarts a daemon that it has not heard of. Returns nothing
// if it does not want to.
std::optional<std::chrono::milliseconds> WatchdogInterval();

// Tells the service manager at each interval that the daemon is alive. Owns one thread if there is
// an interval.
class Watchdog {
 public:
  // `alive` runs on the watchdog's thread and may need one interval itself.
  Watchdog(std::optional<std::chrono::milliseconds> interval, std::function<bool()> alive);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  void Run(std::chrono::milliseconds interval);

  const std::function<bool()> alive_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;  // guarded by mutex_
  std::thread thread_;   // last: it uses the members above
};

}  // namespace sweepstake::server
