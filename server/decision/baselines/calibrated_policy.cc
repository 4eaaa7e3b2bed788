#include "server/decision/baselines/calibrated_policy.h"

#include <algorithm>
#include <utility>

#include "server/decision/policy/log_cost.h"
#include "server/decision/policy/posterior_update.h"

namespace sweepstake::decision {
namespace {

constexpr double kFirstVariance = 0.05 * 0.05;
constexpr double kFirstFreedom = 4;  // windows that the first guess is worth
constexpr double kLeastVariance = 0.002 * 0.002;
constexpr double kMostCorrelation = 0.8;

}  // namespace

void PooledVariance::Add(uint32_t index, double log_cost) {
  Arm& arm = arms_[index];
  arm.count += 1;
  const double residual = log_cost - arm.mean;
  arm.mean += residual / arm.count;
  if (arm.count > 1) {
    freedom_ += 1;
    squares_ += residual * (log_cost - arm.mean);
    products_ += residual * arm.last_residual;
  }
  arm.last_residual = log_cost - arm.mean;
}

double PooledVariance::value() const {
  const double squares = squares_ + kFirstFreedom * kFirstVariance;
  const double variance = squares / (freedom_ + kFirstFreedom);
  const double correlation = std::clamp(products_ / squares, 0.0, kMostCorrelation);
  return std::max(variance * (1 + correlation) / (1 - correlation), kLeastVariance);
}

CalibratedPolicy::CalibratedPolicy(const PolicySetup& setup)
    : ThompsonPolicy(setup),
      bail_out_penalty_(setup.options.bail_out_penalty),
      variance_(static_cast<uint32_t>(setup.arms.size())),
      posteriors_(setup.priors) {}

std::optional<Lesson> CalibratedPolicy::LearnWindow(const WindowObservation& observation) {
  const WindowMetrics metrics = observation.window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  const double log_cost = LogCostOf(metrics.detection_ms * 1e3);
  variance_.Add(observation.arm, log_cost);
  const double reward = RewardOf(log_cost);
  const Increment increment = LogCostIncrement(observation.arm, reward, variance_.value());
  Apply(increment, posteriors_);
  return Lesson{.increment = increment, .reward = reward};
}

// As many windows of reward 0 as the paper's penalty has.
Increment CalibratedPolicy::LearnBailOut(uint32_t arm) {
  const double evidence = EvidenceOf(posteriors_[arm].mean(), variance_.value());
  const Increment increment = BailOutIncrement(arm, bail_out_penalty_ * evidence);
  Apply(increment, posteriors_);
  return increment;
}

}  // namespace sweepstake::decision
