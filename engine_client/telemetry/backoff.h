// How long to wait before connecting again: exponential with full jitter, so that ten thousand
// clients of a restarted daemon do not all come back at once.
//
// The same seed gives the same delays. Not thread-safe.
#pragma once

#include <cstdint>

namespace sweepstake {

class Backoff {
 public:
  // REQUIRES: 1 <= min_ms <= max_ms.
  Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed);

  // Uniform in [0, bound], the bound being min_ms at first and doubling up to max_ms with each
  // call.
  uint32_t NextMs();
  // For what trying again soon will not mend: uniform in the upper half of [0, max_ms].
  uint32_t LongMs();
  // Uniform in [0, bound_ms].
  uint32_t JitterMs(uint32_t bound_ms);
  // The connection held: the next delay is short again.
  void Reset() { bound_ms_ = min_ms_; }

 private:
  uint64_t NextRandom();

  const uint32_t min_ms_;
  const uint32_t max_ms_;
  uint32_t bound_ms_;
  uint64_t random_state_;
};

}  // namespace sweepstake
