#include "server/decision/adaptive_policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/decision/log_cost.h"
#include "server/decision/normal_distribution.h"
#include "server/decision/posterior_update.h"

namespace sweepstake::decision {
namespace {

constexpr double kUnsafeShare = 0.6;            // of the bail-out limit: 3 s of 5
constexpr double kUnsafeDeviations = 2.326;     // P = 1 %
constexpr double kPriorVariance = 0.15 * 0.15;  // a prior is not believed closer than this
constexpr double kFlatShare = 0.2;              // of what a prior may be altogether wrong
constexpr double kUnknownDeviation = 0.8;
constexpr double kFlatEvidence = 2.5;  // Beta(1,1) and hardly more
constexpr double kContradiction = 3;   // standard deviations of a visit's noise
constexpr double kVisitDeviation = 0.1;
constexpr double kHorizonCooldowns = 5;
constexpr double kCostsPerCooldown = 20;  // switching takes at most 5 % of the time
constexpr double kFirstCostShare = 0.05;  // of the settling time
constexpr double kCostRate = 0.3;
constexpr double kTie = 0.005;
constexpr double kLongestAdvance = 30;  // decision intervals

double Seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }
constexpr double Square(double x) { return x * x; }

bool IsFlat(const BetaPosterior& prior) { return prior.evidence() < kFlatEvidence; }

}  // namespace

AdaptivePolicy::AdaptivePolicy(const PolicySetup& setup)
    : options_(setup.options),
      filter_(static_cast<uint32_t>(setup.arms.size())),
      has_prior_(setup.arms.size(), false),
      observed_(setup.arms.size(), false),
      posteriors_(setup.arms.size()),
      switch_cost_s_(kFirstCostShare * Seconds(setup.options.settling_ns)) {
  if (setup.has_priors) TakePriors(setup);
  ShowBeliefs();
}

void AdaptivePolicy::TakePriors(const PolicySetup& setup) {
  double sum = 0;
  double count = 0;
  for (const BetaPosterior& prior : setup.priors) {
    if (IsFlat(prior)) continue;
    sum += BeliefOf(prior).mean;
    ++count;
  }
  if (count == 0) return;
  for (uint32_t arm = 0; arm < setup.priors.size(); ++arm) {
    has_prior_[arm] = !IsFlat(setup.priors[arm]);
    NormalBelief belief{sum / count, Square(kUnknownDeviation)};
    if (has_prior_[arm]) belief = BeliefOf(setup.priors[arm]);
    belief.variance = std::max(belief.variance, kPriorVariance);
    filter_.SetPrior(arm, belief);
  }
}

void AdaptivePolicy::DropPriors() {
  filter_ = RelativeCostFilter(filter_.arm_count());
  std::fill(has_prior_.begin(), has_prior_.end(), false);
}

void AdaptivePolicy::AdvanceTo(int64_t now_ns) {
  if (last_advance_ns_ && now_ns > *last_advance_ns_) {
    const double passed_ns = static_cast<double>(now_ns) - static_cast<double>(*last_advance_ns_);
    filter_.Advance(
        std::min(passed_ns / static_cast<double>(options_.decision_interval_ns), kLongestAdvance));
  }
  last_advance_ns_ = now_ns;
}

void AdaptivePolicy::LearnShadow(std::span<const ShadowSample> samples, int64_t now_ns) {
  if (!swept_) DropContradictedPriors(samples);
  AdvanceTo(now_ns);
  for (const ShadowSample& sample : samples) {
    const double log_cost = LogCostOf(static_cast<double>(sample.detection_time_ns) * 1e-3);
    filter_.ObserveShadow(sample.arm, sample.first_frame_index, log_cost);
    observed_[sample.arm] = true;
  }
  swept_ = true;
  last_shadow_ns_ = now_ns;
  ShowBeliefs();
}

// Where the lane's first visits put another arm well ahead of the one that the priors do.
void AdaptivePolicy::DropContradictedPriors(std::span<const ShadowSample> samples) {
  const ShadowSample* expected = nullptr;
  const ShadowSample* cheapest = nullptr;
  for (const ShadowSample& sample : samples) {
    if (!has_prior_[sample.arm]) continue;
    if (!expected || filter_.LogCost(sample.arm).mean < filter_.LogCost(expected->arm).mean)
      expected = &sample;
    if (!cheapest || sample.detection_time_ns < cheapest->detection_time_ns) cheapest = &sample;
  }
  if (!expected) return;
  const double excess = LogCostOf(static_cast<double>(expected->detection_time_ns)) -
                        LogCostOf(static_cast<double>(cheapest->detection_time_ns));
  if (excess > kContradiction * kVisitDeviation) DropPriors();
}

std::optional<Lesson> AdaptivePolicy::LearnWindow(const WindowObservation& observation) {
  const WindowMetrics metrics = observation.window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  AdvanceTo(observation.now_ns);
  const double log_cost = LogCostOf(metrics.detection_ms * 1e3);
  filter_.ObserveLive(observation.arm, log_cost);
  observed_[observation.arm] = true;
  ++window_count_;
  const double share = std::clamp(metrics.detection_ms * metrics.fps * 1e-3, 1e-4, 1.0);
  detection_share_ +=
      (share - detection_share_) / static_cast<double>(std::min<uint64_t>(window_count_, 10));
  ShowBeliefs();
  const double reward = RewardOf(log_cost);
  return Lesson{
      .increment = LogCostIncrement(observation.arm, reward, filter_.live_noise_variance()),
      .reward = reward};
}

Increment AdaptivePolicy::LearnBailOut(uint32_t arm) {
  filter_.Assume(arm, LogCostOf(static_cast<double>(options_.bail_out_ns) * 1e-3));
  observed_[arm] = true;
  ShowBeliefs();
  return BailOutIncrement(arm, options_.bail_out_penalty);
}

void AdaptivePolicy::LearnSwitchCost(uint32_t /*arm*/, const SwitchCost& cost) {
  const double cost_s =
      (static_cast<double>(cost.rebuild_time_ns) + static_cast<double>(cost.settling_cost_ns)) *
      1e-9;
  const double longest_s = Seconds(options_.settling_ns + options_.decision_interval_ns);
  switch_cost_s_ += kCostRate * (std::min(cost_s, longest_s) - switch_cost_s_);
}

std::optional<int64_t> AdaptivePolicy::cooldown_ns() const {
  const int64_t least_ns = options_.settling_ns + options_.decision_interval_ns;
  const double earned_ns = kCostsPerCooldown * switch_cost_s_ * 1e9;
  const double most_ns = static_cast<double>(options_.cooldown_ns);
  return static_cast<int64_t>(
      std::min(std::max(static_cast<double>(least_ns), earned_ns), most_ns));
}

bool AdaptivePolicy::IsSafe(uint32_t arm) const {
  const NormalBelief cost = filter_.LogCost(arm);
  const double limit = LogCostOf(kUnsafeShare * static_cast<double>(options_.bail_out_ns) * 1e-3);
  return cost.mean + kUnsafeDeviations * std::sqrt(cost.variance) < limit;
}

bool AdaptivePolicy::LaneReports(int64_t now_ns) const {
  return last_shadow_ns_ &&
         Seconds(now_ns) - Seconds(*last_shadow_ns_) <= Seconds(options_.cooldown_ns);
}

// Whether the arm may be switched to as far as what is known of it goes.
bool AdaptivePolicy::IsOpen(uint32_t arm, int64_t now_ns) const {
  if (observed_[arm] || has_prior_[arm]) return true;
  return !LaneReports(now_ns) && window_count_ >= 2;
}

AdaptivePolicy::Assessment AdaptivePolicy::Assess(uint32_t active, uint32_t candidate) const {
  const NormalBelief difference = filter_.Difference(active, candidate);
  const double deviation = std::sqrt(difference.variance);
  Assessment result;
  GateTerms& terms = result.terms;
  terms.gain = ExpectedGain(difference.mean, deviation);
  terms.loss = ExpectedGain(-difference.mean, deviation);
  if (has_prior_[candidate] && !observed_[candidate]) {
    const double flat = ExpectedGain(0, kUnknownDeviation);
    terms.gain += kFlatShare * (flat - terms.gain);
    terms.loss += kFlatShare * (flat - terms.loss);
  }
  terms.horizon_s = kHorizonCooldowns * Seconds(options_.cooldown_ns);
  terms.cooldown_s = Seconds(*cooldown_ns());
  terms.cost_s = switch_cost_s_ / detection_share_;
  result.worth = terms.horizon_s * terms.gain - terms.cooldown_s * terms.loss - terms.cost_s;
  return result;
}

uint32_t AdaptivePolicy::Leader() const {
  uint32_t leader = 0;
  for (uint32_t arm = 1; arm < filter_.arm_count(); ++arm) {
    if (filter_.LogCost(arm).mean < filter_.LogCost(leader).mean) leader = arm;
  }
  return leader;
}

Choice AdaptivePolicy::Choose(const ChoiceInput& input) const {
  const uint32_t active = input.active_arm;
  Choice choice;
  choice.candidate = active;
  double best_worth = -std::numeric_limits<double>::infinity();
  for (uint32_t arm = 0; arm < filter_.arm_count(); ++arm) {
    if (arm == active || !IsOpen(arm, input.now_ns) || !IsSafe(arm)) continue;
    const Assessment assessment = Assess(active, arm);
    if (assessment.worth <= best_worth) continue;
    best_worth = assessment.worth;
    choice.candidate = arm;
    choice.gate = assessment.terms;
  }
  if (choice.candidate == active) return choice;
  if (best_worth <= 0) {
    choice.hold = Outcome::kHeldGate;
    if (filter_.Difference(active, choice.candidate).mean <= 0) choice.candidate = active;
  } else if (choice.gate->gain < kTie) {
    choice.hold = Outcome::kHeldTie;
  }
  return choice;
}

// Beta distributions whose means are the arms', and whose differences to the leader are as
// uncertain as the filter's.
void AdaptivePolicy::ShowBeliefs() {
  const uint32_t leader = Leader();
  double least = Square(kUnknownDeviation);
  for (uint32_t arm = 0; arm < filter_.arm_count(); ++arm) {
    if (arm != leader) least = std::min(least, filter_.Difference(arm, leader).variance);
  }
  for (uint32_t arm = 0; arm < filter_.arm_count(); ++arm) {
    const double variance =
        arm == leader ? least / 2 : filter_.Difference(arm, leader).variance - least / 2;
    posteriors_[arm] = BetaOf({filter_.LogCost(arm).mean, variance});
  }
}

}  // namespace sweepstake::decision
