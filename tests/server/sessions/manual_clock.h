// A clock that changes only when the test advances it.
#pragma once

#include <condition_variable>
#include <mutex>

#include "server/sessions/common/decision_loop.h"

namespace sweepstake::sessions {

class ManualClock final : public LoopClock {
 public:
  int64_t NowNs() const override {
    const std::lock_guard lock(mutex_);
    return now_ns_;
  }
  void WaitUntil(int64_t deadline_ns) override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return wake_ || now_ns_ >= deadline_ns; });
    wake_ = false;
  }
  void Wake() override {
    const std::lock_guard lock(mutex_);
    wake_ = true;
    changed_.notify_all();
  }
  void Advance(int64_t by_ns) {
    const std::lock_guard lock(mutex_);
    now_ns_ += by_ns;
    changed_.notify_all();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int64_t now_ns_ = 1'000'000'000;  // guarded by mutex_
  bool wake_ = false;               // guarded by mutex_
};

}  // namespace sweepstake::sessions
