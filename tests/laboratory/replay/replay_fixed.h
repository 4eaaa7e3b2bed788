// The cost of a traced scene without a policy: each arm alone, and oracles that know all costs in
// advance.
//
// Pure; safe from any thread. Borrows the scene. Times are nanoseconds of virtual time. All of them
// play the same frames as Replay with the same seed, and pay neither for an exploration nor for
// building their first structure.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

// Computes what fixed arms and the oracles cost on the frames of one seed's game.
class FixedCosts {
 public:
  FixedCosts(const ReplayScene& scene, uint64_t seed);

  // Returns the total time of the frames from `first_frame` on, per arm.
  std::vector<double> TotalsFrom(uint32_t first_frame) const;

  struct OracleCost {
    double frame_ns = 0;        // the best arm of each frame, with free switches
    double regime_ns = 0;       // the cheapest sequence of arms that pays for its switches
    uint32_t switch_count = 0;  // in that sequence
    uint32_t dominant_arm = 0;  // in that sequence
    double active_share = 1;    // the dominant arm's
  };
  // Finds both oracles in O(frames × arms). The sequence may switch once per `interval_ns` of the
  // best arm's frames, as a policy may at its ticks. If `warm`, each switch has the cost of a
  // switch that the shadow lane has prepared, else the cost of a cold switch.
  OracleCost Oracle(int64_t interval_ns, bool warm) const;

 private:
  static constexpr uint32_t kBlock = 1024;

  double FrameNs(uint32_t game_frame, uint32_t arm) const;
  double SwitchNs(uint32_t game_frame, uint32_t arm, bool warm) const;

  const ReplayScene& scene_;
  std::vector<uint32_t> order_;     // the trace frame of each game frame
  std::vector<double> from_block_;  // block-major: totals from the block's first frame on
};

}  // namespace sweepstake::cli
