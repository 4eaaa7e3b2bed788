// Random numbers that depend on their purpose and index, not on how many were drawn before, and
// draws from the normal, gamma and Beta distributions. They have the same bits on every platform.
//
// The generator is Philox4x32-10, which is counter-based (J. Salmon, M. Moraes, R. Dror, D. Shaw,
// "Parallel random numbers: as easy as 1, 2, 3", SC 2011). Its key is the session's seed, and its
// counter consists of purpose, decision and index. A session that continues after a restart
// therefore draws the same numbers as without the restart. Plain values; distinct streams are
// independent. Not for secrets.
#pragma once

#include <array>
#include <cstdint>

#include "engine_client/math/beta_distribution.h"

namespace sweepstake::decision {

using PhiloxBlock = std::array<uint32_t, 4>;
using PhiloxKey = std::array<uint32_t, 2>;

// Computes ten rounds of Philox4x32.
PhiloxBlock Philox4x32(PhiloxBlock counter, PhiloxKey key);

// The purpose of a stream. It is part of the counter, so that streams never share numbers.
enum class RandomPurpose : uint32_t {
  kExplorationOrder = 1,
  kChoice = 2,
  kReplayLane = 3,
  kReplayLoad = 4,
  kReplayClass = 5
};

class RandomStream {
 public:
  // `index` (an arm, below 2^16) and `decision_id` distinguish the streams of one purpose.
  RandomStream(uint64_t seed, RandomPurpose purpose, uint64_t decision_id, uint32_t index);

  uint64_t NextBits();
  // Returns a uniform number in the open interval (0, 1) with 52 bits.
  double NextUniform();
  // Returns a uniform number in 0 … bound − 1. REQUIRES: bound > 0.
  uint32_t NextBelow(uint32_t bound);

 private:
  PhiloxKey key_;
  PhiloxBlock counter_;  // word 0 counts blocks
  PhiloxBlock block_{};
  uint32_t used_words_ = 4;
};

// Draws from the standard normal distribution by Marsaglia's polar method (SIAM Review 6, 1964).
double DrawNormal(RandomStream& stream);

// Returns the natural logarithm of a Gamma(shape, 1) draw (G. Marsaglia, W. W. Tsang, "A simple
// method for generating gamma variables", ACM TOMS 26, 2000). For small shapes the value itself
// would underflow. REQUIRES: shape is not NaN. It counts as the nearest of 1e-300 to 1e300.
double DrawLogGamma(double shape, RandomStream& stream);

// Draws from Beta(alpha, beta) as X / (X + Y) of two gamma draws. The result is in [0, 1], never
// NaN. REQUIRES: both parameters are finite and > 0.
double DrawBeta(const BetaPosterior& posterior, RandomStream& stream);

}  // namespace sweepstake::decision
