// The delay before a reconnection: exponential back-off with full jitter. So ten thousand clients
// of a restarted daemon do not all reconnect at the same time.
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

  // Returns a random delay, uniform in [0, bound]. The bound is min_ms at first. Each call doubles
  // it, up to max_ms.
  uint32_t NextMs();
  // Returns the delay after an error that is likely to persist: random, uniform in [max_ms / 2,
  // max_ms].
  uint32_t LongMs();
  // Returns a random number, uniform in [0, bound_ms].
  uint32_t JitterMs(uint32_t bound_ms);
  // Sets the bound back to min_ms. Call it after a connection that lasted for a while.
  void Reset() { bound_ms_ = min_ms_; }

 private:
  const uint32_t min_ms_;
  const uint32_t max_ms_;
  uint32_t bound_ms_;
  math::SplitMix64 random_;
};

}  // namespace sweepstake
