// A run of the paper's experiment in virtual time: the real decision::DecisionSession with the
// policy `paper` and the paper's intervals, and a game whose frames cost what a fit says.
//
// Deterministic: the same fit and seed give the same run, bit for bit. No clock; safe from any
// thread. Cost: some 2 ms for a run at 60 FPS.
//
// Each frame takes its arm's frame time, of which detection is a part, both times a wobble that is
// drawn anew every second. A command is executed at the next frame, which builds the structure
// and takes as long as any other: the settling time keeps it out of the windows anyway. Memory
// (4 MiB) and checks (1 % of all pairs) are the same for all arms, so that a fit says all by times.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace sweepstake::cli {

inline constexpr std::array<std::string_view, 7> kPaperArms = {
    "BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"};

inline constexpr size_t kPaperArmCount = kPaperArms.size();

// What an arm's frames cost.
struct PaperArmFit {
  double frame_ms = 0;      // mean, > 0
  double detection_ms = 0;  // of it
  double noise_ratio = 0;   // standard deviation of the wobble, relative; >= 0
  bool operator==(const PaperArmFit&) const = default;
};

struct PaperCellFit {
  std::array<PaperArmFit, kPaperArmCount> arms;  // by kPaperArms
  // Share of the time, at the end of each period, that is lost in frames of 6 s which are no arm's
  // fault; 0 to below 1. They are over the bail-out limit, and detection is under half of them:
  // recorded, not learnt.
  double stall_ratio = 0;
  double stall_period_s = 200;
  bool operator==(const PaperCellFit&) const = default;
};

struct PaperGame {
  uint64_t switch_count = 0;  // executed in the 15 minutes after the exploration
  uint32_t dominant_arm = 0;  // longest active in them
  double active_percent = 0;  // its share of them
  double posterior_mean = 0;  // its μ* = α ÷ (α + β)
  double evidence = 0;        // its n* = α + β
};

PaperGame PlayPaperGame(const PaperCellFit& fit, uint64_t seed);

}  // namespace sweepstake::cli
