// The clock of the decision loop: what time it is, and waiting for a time. Tests script it.
//
// Nanoseconds from any origin, never going back, whatever the wall clock does. NowNs and Wake may
// be called from any thread; WaitUntil from one.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace sweepstake::rpc {

class Clock {
 public:
  static constexpr int64_t kNever = INT64_MAX;

  virtual ~Clock() = default;
  virtual int64_t NowNs() const = 0;
  // Returns when NowNs() >= deadline_ns, or Wake was called since the last return, or earlier.
  virtual void WaitUntil(int64_t deadline_ns) = 0;
  virtual void Wake() = 0;
};

// std::chrono::steady_clock.
class SteadyClock final : public Clock {
 public:
  int64_t NowNs() const override;
  void WaitUntil(int64_t deadline_ns) override;
  void Wake() override;

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
  bool wake_ = false;  // guarded by mutex_
};

}  // namespace sweepstake::rpc
