// Random numbers of scenes. They are the same on every platform, unlike the numbers of the standard
// library's distributions.
//
// CounterRandom computes a number from (seed, stream, object, counter). Numbers are not drawn in
// order, so another draw, object or frame changes no other number. SequentialRandom draws in order;
// it is for scenes that are defined by the order of their draws.
//
// Thread safety: CounterRandom is immutable; a SequentialRandom is used by one thread at a time.
// Cost: two 64-bit mixes per number of CounterRandom, one per draw of SequentialRandom.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/math/hash.h"

namespace sweepstake {

// Returns the upper 24 bits as a float in [0, 1). A float represents all 24 bits exactly.
inline float UnitFloat(uint64_t bits) {
  return static_cast<float>(bits >> 40U) * (1.0F / 16777216.0F);
}

// The purpose of a number. The values are part of every seed: append new ones, never reorder them.
enum class SceneDraw : uint64_t { kSize = 1, kPosition, kVelocity, kDirection, kKick, kPhase };

// Immutable.
class CounterRandom {
 public:
  CounterRandom(uint64_t seed, SceneDraw stream)
      : key_(math::Mix64(math::Mix64(seed + math::kGoldenGamma) +
                         static_cast<uint64_t>(stream) * math::kGoldenGamma)) {}

  uint64_t Bits(uint64_t object, uint64_t counter) const {
    const uint64_t object_key = math::Mix64(key_ + (object + 1) * math::kGoldenGamma);
    return math::Mix64(object_key + (counter + 1) * math::kGoldenGamma);
  }

  // Returns a number in [0, 1).
  float Unit(uint64_t object, uint64_t counter) const { return UnitFloat(Bits(object, counter)); }

  // Returns a number in [-1, 1).
  float Symmetric(uint64_t object, uint64_t counter) const {
    return Unit(object, counter) * 2.0F - 1.0F;
  }

 private:
  uint64_t key_;
};

// Draws from splitmix64.
class SequentialRandom {
 public:
  explicit SequentialRandom(uint64_t seed) : generator_{seed} {}

  uint64_t Next() { return generator_.Next(); }
  // Returns a number in [0, 1), in steps of 2^-24.
  float Unit() { return UnitFloat(Next()); }
  // Returns a number in [-1, 1).
  float Symmetric() { return Unit() * 2.0F - 1.0F; }
  float Between(float low, float high) { return low + (high - low) * Unit(); }
  // Returns a number in [0, count). REQUIRES: count > 0.
  size_t Below(size_t count) { return static_cast<size_t>(Next() % count); }

 private:
  math::SplitMix64 generator_;
};

}  // namespace sweepstake
