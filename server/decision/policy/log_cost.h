// Reward version 2: absolute, on the logarithm of the detection time alone, so that rewards of
// different times and arms compare.
//
// A cost is y = ln(mean detection time in µs), its reward r = clamp(1 − y / ln(5 s in µs), 0, 1):
// a stall of 5 s is 0, 1 µs is 1. A normal belief about y shows, and is stored, as the Beta
// distribution with the same mean and variance of r. Pure functions; nothing is infinite or NaN.
#pragma once

#include "server/decision/types.h"

namespace sweepstake::decision {

inline constexpr double kLeastLogCost = -7;  // 1 ns
inline constexpr double kMostLogCost = 23;   // some 3 hours

struct NormalBelief {
  double mean = 0;
  double variance = 0;
};

// NaN is the most.
double LogCostOf(double detection_us);
double RewardOf(double log_cost);
double LogCostOfReward(double reward);

// α + β of the Beta distribution with this mean whose reward varies as a log-cost of this variance
// does; at least 1.
double EvidenceOf(double reward, double log_cost_variance);
BetaPosterior BetaOf(const NormalBelief& log_cost);
NormalBelief BeliefOf(const BetaPosterior& posterior);

// One window of this reward.
Increment LogCostIncrement(uint32_t arm, double reward, double log_cost_variance);

}  // namespace sweepstake::decision
