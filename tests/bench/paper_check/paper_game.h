// A run of the paper's experiment in virtual time: the real decision::DecisionSession with the
// paper's intervals, and a game whose frames cost what two numbers say.
//
// Deterministic: the same arguments give the same run, bit for bit. No clock; safe from any thread.
// Cost: some 2 ms for a run at 60 FPS.
//
// The paper prints no arm's costs. A cell has two of them here: how long the dominant arm's
// detection takes, and by how much that of every other arm, all alike, takes longer. The rest of a
// frame is 12 ms. All times wobble by 1 %, anew every second. A command is executed at the next
// frame, which builds the structure and takes as long as any other. Memory (4 MiB) and checks (1 %
// of all pairs) are the same for all arms.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sweepstake::cli {

inline constexpr std::array<std::string_view, 7> kPaperArms = {
    "BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"};

struct PaperCosts {
  double detection_ms = 0;  // of the dominant arm
  double gap_ms = 0;        // by which the others' takes longer
  bool operator==(const PaperCosts&) const = default;
};

// What decides.
struct PaperRules {
  std::string_view policy = "paper";
  // Frames of a window at least. Fewer wait for the next tick's, and until they are enough nothing
  // is learnt and no arm changed. 0: one is enough, as the policy ships.
  uint32_t min_sample_count = 0;
  bool operator==(const PaperRules&) const = default;
};

struct PaperGame {
  uint64_t switch_count = 0;  // executed in the 15 minutes after the exploration
  uint32_t dominant_arm = 0;  // longest active in them
  double active_percent = 0;  // its share of them
  double posterior_mean = 0;  // its μ* = α ÷ (α + β)
  double evidence = 0;        // its n* = α + β
};

// REQUIRES: the policy is `paper` or `random`, fast_arm is one of kPaperArms, the costs are >= 0.
PaperGame PlayPaperGame(const PaperRules& rules, const PaperCosts& costs, uint32_t fast_arm,
                        uint64_t seed);

}  // namespace sweepstake::cli
