#include "engine_client/decider/policy/log_cost.h"

#include <algorithm>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kLogRange = 0x1.6552c12aad88bp+4;  // ln(5 s in ns): rewards from 1 to 0
constexpr double kLogNs = -0x1.ba18a998fffa0p+2;    // log-cost of 1 ns, whose reward is 1
constexpr double kMaxEvidence = 1e12;
constexpr double kMinDistance = 1e-6;  // minimum distance of a mean from 0 and from 1

}  // namespace

double LogCostOf(double detection_us) {
  const double log_cost = math::Log(std::max(detection_us, 0.0));
  return log_cost <= kMaxLogCost ? std::max(log_cost, kMinLogCost) : kMaxLogCost;
}

double RewardOf(double log_cost) {
  return std::clamp(1 - (log_cost - kLogNs) / kLogRange, 0.0, 1.0);
}

double LogCostOfReward(double reward) { return kLogNs + (1 - reward) * kLogRange; }

double LogCostVarianceOf(double reward_variance) { return reward_variance * kLogRange * kLogRange; }

double EvidenceOf(double reward, double log_cost_variance) {
  const double variance = log_cost_variance / (kLogRange * kLogRange);
  const double bernoulli_variance = reward * (1 - reward);
  return bernoulli_variance < kMaxEvidence * variance ? std::max(bernoulli_variance / variance, 1.0)
                                                      : kMaxEvidence;
}

BetaPosterior BetaOf(const NormalBelief& log_cost) {
  const double mean = std::clamp(RewardOf(log_cost.mean), kMinDistance, 1 - kMinDistance);
  const double evidence = EvidenceOf(mean, log_cost.variance);
  return {mean * evidence, (1 - mean) * evidence};
}

NormalBelief BeliefOf(const BetaPosterior& posterior) {
  const double mean = posterior.mean();
  return {.mean = LogCostOfReward(mean),
          .variance = LogCostVarianceOf(mean * (1 - mean) / (posterior.evidence() + 1))};
}

CostRatio CostRatioOf(const BetaPosterior& arm, const BetaPosterior& leader) {
  const NormalBelief cost = BeliefOf(arm);
  const NormalBelief least = BeliefOf(leader);
  const double difference = cost.mean - least.mean;
  const double reach = kDeviations95 * std::sqrt(cost.variance + least.variance);
  return {.median = math::Exp(difference),
          .low = math::Exp(difference - reach),
          .high = math::Exp(difference + reach)};
}

Increment LogCostIncrement(uint32_t arm, double reward, double log_cost_variance) {
  const double evidence = EvidenceOf(reward, log_cost_variance);
  return {
      .arm = arm, .alpha = evidence * reward, .beta = evidence * (1 - reward), .window_count = 1};
}

}  // namespace sweepstake::decision
