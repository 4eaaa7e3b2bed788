// The wall clock, for times that people read or that outlive the process. It may jump, so durations
// and timeouts use a steady clock.
#pragma once

#include <chrono>
#include <cstdint>

namespace sweepstake::priors {

// The time since 1970 (UTC), rounded down.
template <typename Unit>
int64_t UnixNow() {
  return std::chrono::floor<Unit>(std::chrono::system_clock::now().time_since_epoch()).count();
}

inline int64_t UnixNowNs() { return UnixNow<std::chrono::nanoseconds>(); }
inline int64_t UnixNowMs() { return UnixNow<std::chrono::milliseconds>(); }
inline int64_t UnixNowS() { return UnixNow<std::chrono::seconds>(); }

}  // namespace sweepstake::priors
