// A run of the paper's experiment in virtual time: the real decision::DecisionSession with the
// paper's intervals, and a game with frame costs given by two numbers.
//
// Deterministic: the same arguments give the same run, bit for bit. No clock; safe from any thread.
// Cost: about 2 ms for a run at 60 FPS.
//
// The paper gives no costs of arms. Here a cell has two costs: the detection time of the dominant
// arm, and the difference to all other arms, which are alike. The rest of a frame takes 12 ms. All
// times vary by 1 %, with a new value every second. A command is executed in the next frame, which
// builds the structure and takes as long as any other. Memory (4 MiB) and checks (1 % of all pairs)
// are the same for all arms.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sweepstake::cli {

inline constexpr std::array<std::string_view, 7> kPaperArms = {
    "BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"};

struct PaperCosts {
  double detection_ms = 0;  // detection time of the dominant arm
  double gap_ms = 0;        // how much longer the other arms take
  bool operator==(const PaperCosts&) const = default;
};

// The policy and its settings.
struct PaperRules {
  std::string_view policy = "paper";
  // Minimum number of frames in a window. With fewer frames the window continues in the next tick;
  // until then nothing is learnt and the arm does not change. 0: one frame is enough, as in the
  // shipped policy.
  uint32_t min_sample_count = 0;
  bool operator==(const PaperRules&) const = default;
};

struct PaperGame {
  uint64_t switch_count = 0;  // executed in the 15 minutes after the exploration
  uint32_t dominant_arm = 0;  // the arm with the longest active time in this period
  double active_percent = 0;  // share of dominant_arm in the active time
  double posterior_mean = 0;  // μ* = α ÷ (α + β) of dominant_arm
  double evidence = 0;        // n* = α + β of dominant_arm
};

// REQUIRES: the policy is `paper` or `random`, fast_arm is one of kPaperArms, the costs are >= 0.
PaperGame PlayPaperGame(const PaperRules& rules, const PaperCosts& costs, uint32_t fast_arm,
                        uint64_t seed);

}  // namespace sweepstake::cli
