// Random numbers as a function of (seed, stream, object, counter): nothing is drawn in order, so
// that adding a draw, an object or a frame somewhere shifts no other number.
//
// Immutable value type, safe from any thread. A draw costs two 64-bit mixes, about 3 ns.
#pragma once

#include <cstdint>

namespace sweepstake {

// splitmix64's increment (2^64 / golden ratio) and output mix (Steele, Lea, Flood 2014).
inline constexpr uint64_t kGoldenGamma = 0x9E3779B97F4A7C15U;

inline uint64_t Mix64(uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

// The upper 24 bits as a float in [0, 1): every value exact.
inline float UnitFloat(uint64_t bits) {
  return static_cast<float>(bits >> 40U) * (1.0F / 16777216.0F);
}

// What a number is for. The values are part of every seed's meaning: append, never reorder.
enum class RandomStream : uint64_t { kSize = 1, kPosition, kVelocity, kDirection, kKick, kPhase };

class CounterRandom {
 public:
  CounterRandom(uint64_t seed, RandomStream stream)
      : key_(Mix64(Mix64(seed + kGoldenGamma) + static_cast<uint64_t>(stream) * kGoldenGamma)) {}

  uint64_t Bits(uint64_t object, uint64_t counter) const {
    const uint64_t object_key = Mix64(key_ + (object + 1) * kGoldenGamma);
    return Mix64(object_key + (counter + 1) * kGoldenGamma);
  }

  // In [0, 1).
  float Unit(uint64_t object, uint64_t counter) const { return UnitFloat(Bits(object, counter)); }

  // In [-1, 1).
  float Symmetric(uint64_t object, uint64_t counter) const {
    return Unit(object, counter) * 2.0F - 1.0F;
  }

 private:
  uint64_t key_;
};

}  // namespace sweepstake
