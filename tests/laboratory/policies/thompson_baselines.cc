#include "tests/laboratory/policies/thompson_baselines.h"

#include <algorithm>
#include <utility>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/posterior_update.h"

namespace sweepstake::decision {
namespace {

constexpr double kFirstVariance = 0.05 * 0.05;  // the first guess of a log-cost's variance
constexpr double kFirstDegrees = 4;  // the first guess weighs as much as this many windows
constexpr double kMinVariance = 0.002 * 0.002;
constexpr double kMaxCorrelation = 0.8;

}  // namespace

Choice OneDrawPolicy::Choose(const ChoiceInput& input) const {
  return IsTimeToChoose(input, cooldown_ns_) ? ThompsonPolicy::Choose(input)
                                             : ChoiceOf(input.active_arm);
}

std::optional<WindowUpdate> DiscountedPolicy::LearnWindow(const WindowObservation& observation) {
  const std::optional<WindowUpdate> update = ThompsonPolicy::LearnWindow(observation);
  if (!update) return update;
  for (BetaPosterior& posterior : discounted_) {
    posterior.alpha = 1 + kDiscount * (posterior.alpha - 1);
    posterior.beta = 1 + kDiscount * (posterior.beta - 1);
  }
  Apply(update->increment, discounted_);
  return update;
}

Increment DiscountedPolicy::LearnBailOut(uint32_t arm) {
  const Increment increment = ThompsonPolicy::LearnBailOut(arm);
  Apply(increment, discounted_);
  return increment;
}

void PooledVariance::Add(uint32_t index, double log_cost) {
  Arm& arm = arms_[index];
  arm.count += 1;
  const double residual = log_cost - arm.mean;
  arm.mean += residual / arm.count;
  if (arm.count > 1) {
    degrees_ += 1;
    squares_ += residual * (log_cost - arm.mean);
    products_ += residual * arm.last_residual;
  }
  arm.last_residual = log_cost - arm.mean;
}

double PooledVariance::value() const {
  const double squares = squares_ + kFirstDegrees * kFirstVariance;
  const double variance = squares / (degrees_ + kFirstDegrees);
  const double correlation = std::clamp(products_ / squares, 0.0, kMaxCorrelation);
  return std::max(variance * (1 + correlation) / (1 - correlation), kMinVariance);
}

CalibratedPolicy::CalibratedPolicy(const PolicySetup& setup)
    : ThompsonPolicy(setup),
      bail_out_penalty_(setup.options.bail_out_penalty),
      variance_(static_cast<uint32_t>(setup.arms.size())),
      posteriors_(setup.priors) {}

std::optional<WindowUpdate> CalibratedPolicy::LearnWindow(const WindowObservation& observation) {
  const WindowMetrics metrics = observation.window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  const double log_cost = LogCostOf(metrics.detection_ms * 1e3);
  variance_.Add(observation.arm, log_cost);
  const double reward = RewardOf(log_cost);
  const Increment increment = LogCostIncrement(observation.arm, reward, variance_.value());
  Apply(increment, posteriors_);
  return WindowUpdate{.increment = increment, .reward = reward};
}

// The penalty is that number of windows of reward 0, where the paper counts observations.
double CalibratedPolicy::WindowEvidence(uint32_t arm) const {
  return EvidenceOf(posteriors_[arm].mean(), variance_.value());
}

Increment CalibratedPolicy::LearnBailOut(uint32_t arm) {
  const Increment increment = BailOutIncrement(arm, bail_out_penalty_ * WindowEvidence(arm));
  Apply(increment, posteriors_);
  return increment;
}

}  // namespace sweepstake::decision
