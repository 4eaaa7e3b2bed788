// Notifications to the service manager that started the daemon: systemd, or another one that sets
// NOTIFY_SOCKET. Without that variable the functions do nothing.
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
// Extends the service manager's stop timeout to `time` from now.
void NotifyStoppingTakes(std::chrono::microseconds time);

// Returns the interval of watchdog notifications: a quarter of WATCHDOG_USEC. After WATCHDOG_USEC
// without a notification, the service manager restarts the daemon. Nothing if there is no watchdog.
std::optional<std::chrono::milliseconds> WatchdogInterval();

// Notifies the service manager at each interval if the daemon is alive. Owns one thread if there is
// an interval.
class Watchdog {
 public:
  // `alive` runs on the watchdog's thread, for at most one interval.
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
