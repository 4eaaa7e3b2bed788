#include "engine_client/telemetry/protocol/backoff.h"

#include <algorithm>
#include <cassert>

namespace sweepstake {

Backoff::Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed)
    : min_ms_(min_ms), max_ms_(max_ms), bound_ms_(min_ms), random_{seed} {
  assert(min_ms >= 1 && min_ms <= max_ms);
}

uint32_t Backoff::NextMs() {
  const uint32_t delay_ms = JitterMs(bound_ms_);
  bound_ms_ = static_cast<uint32_t>(std::min<uint64_t>(uint64_t{bound_ms_} * 2, max_ms_));
  return delay_ms;
}

uint32_t Backoff::LongMs() {
  bound_ms_ = max_ms_;
  const uint32_t half_ms = max_ms_ / 2;
  return max_ms_ - JitterMs(half_ms);
}

uint32_t Backoff::JitterMs(uint32_t bound_ms) {
  // Scale the upper 32 bits to the range. The method has a small bias, which does not matter for a
  // delay.
  return static_cast<uint32_t>(((random_.Next() >> 32) * (uint64_t{bound_ms} + 1)) >> 32);
}

}  // namespace sweepstake
