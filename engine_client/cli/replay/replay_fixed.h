// What a traced scene costs without a policy: each arm alone, and oracles that know everything.
//
// Pure; safe from any thread. Borrows the scene. Nanoseconds of virtual time. All of them play the
// very frames that Replay plays with the same seed, and pay neither for an exploration nor for
// building their first structure.
#pragma once

#include <cstdint>
#include <vector>

#include "engine_client/cli/replay/replay_scene.h"

namespace sweepstake::cli {

// The frames of one seed's game.
class FixedCosts {
 public:
  FixedCosts(const ReplayScene& scene, uint64_t seed);

  // Of the frames from `first_frame` on, per arm.
  std::vector<double> TotalsFrom(uint32_t first_frame) const;

  struct OracleCost {
    double frame_ns = 0;        // the best arm of each frame, switching for nothing
    double regime_ns = 0;       // the cheapest sequence of arms that pays for its switches
    uint32_t switch_count = 0;  // of the latter
    uint32_t dominant_arm = 0;  // of that sequence
    double active_share = 1;    // of the dominant arm
  };
  // The latter may switch once per `interval_ns` of the best arm's frames, as a policy may at
  // ticks; `warm`: at the cost of a switch that the shadow lane prepared, else of a cold one. Found
  // by dynamic programming in O(frames × arms).
  OracleCost Oracle(int64_t interval_ns, bool warm) const;

 private:
  static constexpr uint32_t kBlock = 1024;

  double FrameNs(uint32_t game_frame, uint32_t arm) const;
  double SwitchNs(uint32_t game_frame, uint32_t arm, bool warm) const;

  const ReplayScene& scene_;
  std::vector<uint32_t> order_;     // the trace frame of each game frame
  std::vector<double> from_block_;  // block-major: totals from this block's first frame on
};

}  // namespace sweepstake::cli
