// Random numbers drawn in order: splitmix64, the same everywhere, unlike the distributions of the
// standard library. For scenes whose history of draws is their definition; the others use
// counter_random.h.
//
// Not thread-safe. A draw costs one 64-bit mix.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/scene/counter_random.h"

namespace sweepstake {

class SequentialRandom {
 public:
  explicit SequentialRandom(uint64_t seed) : state_(seed) {}

  uint64_t Next() { return Mix64(state_ += kGoldenGamma); }
  // In [0, 1), in steps of 2^-24.
  float Unit() { return UnitFloat(Next()); }
  // In [-1, 1).
  float Symmetric() { return Unit() * 2.0F - 1.0F; }
  float Between(float low, float high) { return low + (high - low) * Unit(); }
  // In [0, count). REQUIRES: count > 0.
  size_t Below(size_t count) { return static_cast<size_t>(Next() % count); }

 private:
  uint64_t state_;
};

}  // namespace sweepstake
