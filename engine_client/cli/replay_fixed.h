// What a traced scene costs without a policy: each arm alone, and oracles that know everything.
//
// Pure; safe from any thread with one scene. Nanoseconds of virtual time. All of them play the very
// frames that Replay plays with the same seed, and pay neither for an exploration nor for building
// their first structure.
#pragma once

#include <cstdint>
#include <vector>

#include "engine_client/cli/replay_scene.h"

namespace sweepstake::cli {

struct OracleCost {
  double frame_ns = 0;        // the best arm of each frame, switching for nothing
  double regime_ns = 0;       // the best sequence of arms that pays for each switch
  uint32_t switch_count = 0;  // of the latter
};

// The frames of one seed's game.
class FixedCosts {
 public:
  FixedCosts(const ReplayScene& scene, uint64_t seed);

  // Of all frames from `first_frame` on, per arm.
  std::vector<double> TotalsFrom(uint32_t first_frame) const;
  // The arm with the smallest total.
  static uint32_t Best(const std::vector<double>& totals);

 private:
  static constexpr uint32_t kBlock = 1024;

  const ReplayScene& scene_;
  uint64_t seed_;
  std::vector<double> from_block_;  // block-major: totals of the frames from this block's first on
};

// Frames may be switched at every decision interval, as a policy might at most; `warm`: at the cost
// of a switch that the shadow lane prepared, else of a cold one. Dynamic programming, O(frames ×
// arms).
OracleCost Oracle(const ReplayScene& scene, uint64_t seed, bool warm);

}  // namespace sweepstake::cli
