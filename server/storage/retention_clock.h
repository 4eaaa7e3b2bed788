// The time by which a store removes old rows. It follows the wall clock, but moves at most
// kMaxSpeed times as fast as the steady clock. A wall clock that is years ahead for an hour thus
// removes at most kMaxSpeed hours of rows. After a daemon was off for a month, the retention clock
// is right again within a day.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sweepstake::storage {

class RetentionClock {
 public:
  static constexpr double kMaxSpeed = 30;

  // `start_s` is the time at which the latest chunk of rows began, in seconds since 1970; 0: there
  // is none, and the wall clock is trusted.
  explicit RetentionClock(uint64_t start_s) : now_s_(static_cast<double>(start_s)) {}

  // Returns the time in seconds since 1970, never later than `unix_now_s`. `steady_ns` never
  // decreases.
  uint64_t Follow(uint64_t unix_now_s, int64_t steady_ns) {
    const auto wall_s = static_cast<double>(unix_now_s);
    if (now_s_ == 0) now_s_ = wall_s;
    const double passed_s = last_ns_ == 0 ? 0 : static_cast<double>(steady_ns - last_ns_) * 1e-9;
    last_ns_ = steady_ns;
    now_s_ = std::clamp(wall_s, now_s_ - kMaxSpeed * passed_s, now_s_ + kMaxSpeed * passed_s);
    return static_cast<uint64_t>(std::min(now_s_, wall_s));
  }

 private:
  double now_s_;
  int64_t last_ns_ = 0;  // 0: not followed yet
};

}  // namespace sweepstake::storage
