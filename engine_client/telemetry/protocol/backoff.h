// The delay before a reconnection: exponential back-off with full jitter, so that ten thousand
// clients of a restarted daemon do not reconnect at the same time.
//
// The same seed gives the same delays. Not thread-safe.
#pragma once

#include <cstdint>

#include "engine_client/math/hash.h"

namespace sweepstake {

class Backoff {
 public:
  // REQUIRES: 1 <= min_ms <= max_ms.
  Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed);

  // Returns a delay that is uniform in [0, bound]. The bound is min_ms at first and doubles with
  // each call, up to max_ms.
  uint32_t NextMs();
  // Returns the delay after an error that is likely to persist: uniform in the upper half of [0,
  // max_ms].
  uint32_t LongMs();
  // Returns a number that is uniform in [0, bound_ms].
  uint32_t JitterMs(uint32_t bound_ms);
  // Resets the bound to min_ms. Call it after a connection that lasted.
  void Reset() { bound_ms_ = min_ms_; }

 private:
  const uint32_t min_ms_;
  const uint32_t max_ms_;
  uint32_t bound_ms_;
  math::SplitMix64 random_;
};

}  // namespace sweepstake
