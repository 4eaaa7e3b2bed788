// Reward version 3 depends on the logarithm of the detection time alone and is absolute, so that
// rewards of different times and arms can be compared.
//
// A log-cost is y = ln(mean detection time in µs) of calm frames (window.h), and its reward is r =
// clamp(1 − ln(detection time in ns) / ln(5 s in ns), 0, 1): a stall of 5 s has reward 0, 1 ns has
// reward 1. A normal belief about y is shown and stored as the Beta distribution with the same mean
// and variance of r. Pure functions; no result is infinite or NaN.
#pragma once

#include <cstdint>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

inline constexpr uint32_t kLogCostRewardVersion = 3;
inline constexpr double kMinLogCost = -7;  // 1 ns
inline constexpr double kMaxLogCost = 23;  // some 3 hours

// The variance of ln(cost that the shadow lane measures ÷ live cost) of an arm. Without other load
// the lane took 0.83 (DBVT) to 1.21 (Tracy) of the frame thread's time on an AMD Zen 4. A factor
// that all arms share (1.1 to 1.4 on a Zen 3) is not included; the filter estimates it separately.
inline constexpr double kLaneBiasVariance = 0.15 * 0.15;

struct NormalBelief {
  double mean = 0;
  double variance = 0;
};

// Returns the log-cost, clamped to kMinLogCost … kMaxLogCost; NaN gives the maximum.
double LogCostOf(double detection_us);
double RewardOf(double log_cost);
double LogCostOfReward(double reward);
// Returns the variance of log-costs whose rewards have this variance.
double LogCostVarianceOf(double reward_variance);

// Returns α + β, at least 1, of the Beta distribution with the mean `reward` and the variance that
// a log-cost of this variance gives a reward.
double EvidenceOf(double reward, double log_cost_variance);
BetaPosterior BetaOf(const NormalBelief& log_cost);
NormalBelief BeliefOf(const BetaPosterior& posterior);

// Returns an arm's cost ÷ the leader's cost from two independent posteriors.
CostRatio CostRatioOf(const BetaPosterior& arm, const BetaPosterior& leader);

// Returns the increment of one window, or one visit of the lane, with this reward (version 3's
// update rule).
Increment LogCostIncrement(uint32_t arm, double reward, double log_cost_variance);

}  // namespace sweepstake::decision
