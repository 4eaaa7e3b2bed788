// Random numbers addressed by what they are for, not by how many were drawn before: a counter-based
// generator.
//
// Philox4x32-10 (J. Salmon, M. Moraes, R. Dror, D. Shaw, "Parallel random numbers: as easy as 1, 2,
// 3", SC 2011). The key is the session's seed, the counter names purpose, decision and index, so
// that a session that goes on after a restart draws what it would have drawn. Integer arithmetic
// only: the same on every platform. Plain values; distinct streams are independent of each other.
// Not for secrets.
#pragma once

#include <array>
#include <cstdint>

namespace sweepstake::decision {

using PhiloxBlock = std::array<uint32_t, 4>;
using PhiloxKey = std::array<uint32_t, 2>;

// Ten rounds of Philox4x32.
PhiloxBlock Philox4x32(PhiloxBlock counter, PhiloxKey key);

// What a stream is for; part of the counter, so the numbers never coincide.
enum class RandomPurpose : uint32_t { kExplorationOrder = 1, kChoice = 2 };

class RandomStream {
 public:
  // `index` (an arm, below 2^16) and `decision_id` tell streams of one purpose apart.
  RandomStream(uint64_t seed, RandomPurpose purpose, uint64_t decision_id, uint32_t index);

  uint64_t NextBits();
  // Uniform in the open interval (0, 1); 52 bits.
  double NextUniform();
  // Uniform in 0 … bound − 1. REQUIRES: bound > 0.
  uint32_t NextBelow(uint32_t bound);

 private:
  PhiloxKey key_;
  PhiloxBlock counter_;  // word 0 counts blocks
  PhiloxBlock block_{};
  uint32_t used_words_ = 4;
};

}  // namespace sweepstake::decision
