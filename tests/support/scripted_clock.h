// A clock that advances only when the test advances it.
#pragma once

#include <cstdint>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::test_support {

inline constexpr uint64_t kMs = 1'000'000;  // in nanoseconds

class ScriptedClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    ++reading_count_;
    return now_ns_ += reading_ns_;
  }
  void Advance(uint64_t duration_ns) { now_ns_ += duration_ns; }
  // Sets the time by which each reading advances the clock from now on.
  void SetReading(uint64_t duration_ns) { reading_ns_ = duration_ns; }
  uint64_t reading_count() const { return reading_count_; }

 private:
  uint64_t now_ns_ = 0;
  uint64_t reading_ns_ = 0;
  uint64_t reading_count_ = 0;
};

}  // namespace sweepstake::test_support
