#include "engine_client/telemetry/backoff.h"

#include <algorithm>
#include <cassert>

namespace sweepstake {

Backoff::Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed)
    : min_ms_(min_ms), max_ms_(max_ms), bound_ms_(min_ms), random_state_(seed) {
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
  // The upper 32 bits, scaled: even enough for a delay.
  return static_cast<uint32_t>(((NextRandom() >> 32) * (uint64_t{bound_ms} + 1)) >> 32);
}

// splitmix64.
uint64_t Backoff::NextRandom() {
  uint64_t mixed = (random_state_ += 0x9E3779B97F4A7C15);
  mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9;
  mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EB;
  return mixed ^ (mixed >> 31);
}

}  // namespace sweepstake
