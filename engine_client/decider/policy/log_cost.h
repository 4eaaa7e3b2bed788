// Reward version 3. It depends only on the logarithm of the detection time. It is absolute: rewards
// of different times and arms can be compared.
//
// - A log-cost is y = ln(mean detection time in µs) of calm frames (window.h).
// - Its reward is r = clamp(1 − ln(detection time in ns) / ln(5 s in ns), 0, 1): 0 for a stall of 5
//   s, 1 for 1 ns.
// - A normal belief about y is shown and stored as the Beta distribution that has the mean and
//   variance of r.
//
// Pure functions. No result is infinite or NaN.
#pragma once

#include <cstdint>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

inline constexpr uint32_t kLogCostRewardVersion = 3;
inline constexpr double kMinLogCost = -7;  // 1 ns
inline constexpr double kMaxLogCost = 23;  // about 3 hours
// The 97.5 % quantile of a normal distribution: an interval of 95 % reaches this far on both sides.
inline constexpr double kDeviations95 = 1.959963984540054;

// The variance, between arms, of ln(cost that the shadow lane measures ÷ live cost). On an AMD Zen
// 4 without other load, the lane took 0.83 (DBVT) to 1.21 (Tracy) of the frame thread's time. The
// factor that all arms share (1.1 to 1.4 on a Zen 3) is not included here; the filter estimates it.
inline constexpr double kLaneBiasVariance = 0.2 * 0.2;

// The variance of an arm's relative log-cost between two regimes, two sessions or two scenes. A
// belief from one has at least this variance in the other.
inline constexpr double kTransferVariance = 0.3 * 0.3;

// The variance of an unmeasured arm's log-cost relative to the other arms: a factor of 2.2.
inline constexpr double kUnknownVariance = 0.8 * 0.8;

struct NormalBelief {
  double mean = 0;
  double variance = 0;
};

// Returns the log-cost, clamped to kMinLogCost … kMaxLogCost. NaN gives kMaxLogCost.
double LogCostOf(double detection_us);
double RewardOf(double log_cost);
double LogCostOfReward(double reward);
// Returns the variance of log-costs whose rewards have this variance.
double LogCostVarianceOf(double reward_variance);

// Returns α + β of the Beta distribution that has the mean `reward` and the reward variance that
// follows from `log_cost_variance`. The result is at least 1.
double EvidenceOf(double reward, double log_cost_variance);
BetaPosterior BetaOf(const NormalBelief& log_cost);
NormalBelief BeliefOf(const BetaPosterior& posterior);

// Returns (cost of the arm) ÷ (cost of the leader). The two posteriors count as independent.
CostRatio CostRatioOf(const BetaPosterior& arm, const BetaPosterior& leader);

// Returns the increment of one window or one visit of the lane with this reward, by the update rule
// of version 3. The smaller the variance of its log-cost, the larger the increment.
Increment LogCostIncrement(uint32_t arm, double reward, double log_cost_variance);

}  // namespace sweepstake::decision
