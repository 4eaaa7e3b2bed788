#include "server/rpc/clock.h"

#include <chrono>

namespace sweepstake::rpc {

int64_t SteadyClock::NowNs() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void SteadyClock::WaitUntil(int64_t deadline_ns) {
  std::unique_lock lock(mutex_);
  const auto woken = [&] { return wake_; };
  if (deadline_ns == kNever) {
    woken_.wait(lock, woken);
  } else {
    const std::chrono::steady_clock::time_point deadline{std::chrono::nanoseconds(deadline_ns)};
    woken_.wait_until(lock, deadline, woken);
  }
  wake_ = false;
}

void SteadyClock::Wake() {
  {
    const std::lock_guard lock(mutex_);
    wake_ = true;
  }
  woken_.notify_one();
}

}  // namespace sweepstake::rpc
