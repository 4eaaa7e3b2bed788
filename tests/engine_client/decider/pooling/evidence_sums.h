// Makes evidence from costs, and costs from evidence, for tests of priors.
#pragma once

#include <cmath>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::decision {

// Returns the evidence of `count` windows or visits that measured `cost_us` with a noise of 2 %.
inline EvidenceSum SumOf(double cost_us, double count) {
  const Increment one = LogCostIncrement(0, RewardOf(std::log(cost_us)), 0.02 * 0.02);
  return {.alpha = count * one.alpha, .beta = count * one.beta};
}

inline double CostUs(const EvidenceSum& sum) {
  return std::exp(LogCostOfReward(sum.alpha / sum.evidence()));
}

// Returns the standard deviation of the log-cost.
inline double DeviationOf(const EvidenceSum& sum) {
  return std::sqrt(BeliefOf({sum.alpha, sum.beta}).variance);
}

}  // namespace sweepstake::decision
