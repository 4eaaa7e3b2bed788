// All settings of a decision session. The defaults are the paper's values (paper §4 and §6.3).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sweepstake/frame_sample.h"

namespace sweepstake::decision {

struct DecisionOptions {
  std::string policy = "default";  // one of PolicyNames() (session/policy_registry.h)
  RewardWeights weights;
  int64_t decision_interval_ns = 2'000'000'000;  // Δt, the time between two ticks; > 0
  // Minimum time from the latest executed switch, whatever its reason, to the next switch that the
  // policy commands, >= 0.
  int64_t cooldown_ns = 40'000'000'000;
  // Frame time after the first frame on the new arm during which nothing is learnt, >= 0.
  int64_t settling_ns = 2'000'000'000;
  // The maximum of the two times above for a policy with PolicyKind::keeps_regimes, > 0. Such a
  // policy corrects a wrong choice soon, because it decides again when the regime changes.
  int64_t regime_interval_ns = 1'000'000'000;
  // A frame longer than this is a bail-out. Must be > 0. Scaled() leaves it unchanged.
  int64_t bail_out_ns = kBailOutNs;
  int64_t exploration_warm_up_ns = 2'000'000'000;  // time per arm, >= 0
  int64_t exploration_measure_ns = 4'000'000'000;  // time per arm, > 0
  bool explore = true;                             // false: no initial exploration
  double bail_out_penalty = 10;                    // number of observations of reward 0, >= 0
  double fps_floor = 30;  // a scene is degraded below it because of the broad phase, >= 0

  // Returns the options with every interval except bail_out_ns divided by `time_scale`. An interval
  // above 0 stays above 0. REQUIRES: 1 <= time_scale <= 1000.
  DecisionOptions Scaled(double time_scale) const;
  // Returns the options with the rules that a game has set. An interval above kMaxIntervalNs stays
  // invalid.
  DecisionOptions With(const DecisionRules& rules) const;
};

// The largest values that NumberProblems accepts.
inline constexpr int64_t kMaxIntervalNs = 8'640'000'000'000'000;  // 100 days
inline constexpr double kMaxPenalty = 1e6;
inline constexpr double kLargestFpsFloor = 1000;

// Returns one line per invalid number, with the correction. Empty if all are valid. The policy's
// name is checked in session/session_setup.h.
std::vector<std::string> NumberProblems(const DecisionOptions& options);

}  // namespace sweepstake::decision
