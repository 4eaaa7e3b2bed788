#include "server/host/service_manager.h"

#include <systemd/sd-daemon.h>

#include <cstdint>
#include <string>
#include <utility>

namespace sweepstake::server {

void NotifyReady() { sd_notify(/*unset_environment=*/0, "READY=1"); }

void NotifyStopping() { sd_notify(/*unset_environment=*/0, "STOPPING=1"); }

void NotifyStoppingTakes(std::chrono::microseconds time) {
  const std::string message = "EXTEND_TIMEOUT_USEC=" + std::to_string(time.count());
  sd_notify(/*unset_environment=*/0, message.c_str());
}

std::optional<std::chrono::milliseconds> WatchdogInterval() {
  uint64_t limit_us = 0;
  if (sd_watchdog_enabled(/*unset_environment=*/0, &limit_us) <= 0) return std::nullopt;
  return std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::microseconds(limit_us / 4));
}

Watchdog::Watchdog(std::optional<std::chrono::milliseconds> interval, std::function<bool()> alive)
    : alive_(std::move(alive)) {
  if (interval) thread_ = std::thread([this, interval] { Run(*interval); });
}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Watchdog::Run(std::chrono::milliseconds interval) {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    lock.unlock();
    if (alive_()) sd_notify(/*unset_environment=*/0, "WATCHDOG=1");
    lock.lock();
    changed_.wait_for(lock, interval, [this] { return ending_; });
  }
}

}  // namespace sweepstake::server
