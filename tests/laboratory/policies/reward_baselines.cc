#include "tests/laboratory/policies/reward_baselines.h"

#include <algorithm>
#include <array>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754
#include <utility>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {
namespace {

constexpr double kMinEvidence = 1e-6;  // keeps a bound finite for all priors

constexpr double kUnseen = 1e9;  // the log-cost of an arm before the lane's first visit

using Row = std::array<std::string_view, 2>;  // arms in order of preference

Row RowOf(double object_count, double density_ratio) {
  if (object_count < ThresholdsPolicy::kFewObjects) return {"BruteForce", ""};
  const bool sparse =
      object_count <= ThresholdsPolicy::kManyObjects && density_ratio <= ThresholdsPolicy::kDense;
  return sparse ? Row{"AxisSweep", "SAP"} : Row{"KDTree", "DBVT"};
}

}  // namespace

Choice RandomPolicy::Choose(const ChoiceInput& input) const {
  if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
  const auto arm_count = static_cast<uint32_t>(posteriors().size());
  RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
  Choice choice = ChoiceOf(stream.NextBelow(arm_count));
  choice.propensity = 1.0 / arm_count;
  return choice;
}

Choice Ucb1Policy::Choose(const ChoiceInput& /*input*/) const {
  double window_count = 0;
  for (const BetaPosterior& posterior : posteriors()) window_count += posterior.evidence();
  const double log_count = math::Log(std::max(window_count, 1.0));
  std::vector<double> bounds;
  for (const BetaPosterior& posterior : posteriors()) {
    bounds.push_back(posterior.mean() +
                     std::sqrt(2 * log_count / std::max(posterior.evidence(), kMinEvidence)));
  }
  return HighestOf(std::move(bounds));
}

Choice EpsilonGreedyPolicy::Choose(const ChoiceInput& input) const {
  if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
  std::vector<double> means;
  for (const BetaPosterior& posterior : posteriors()) means.push_back(posterior.mean());
  const auto arm_count = static_cast<uint32_t>(means.size());
  Choice choice = HighestOf(std::move(means));
  const uint32_t greedy = choice.candidate;
  RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
  if (stream.NextUniform() < kEpsilon) choice.candidate = stream.NextBelow(arm_count);
  choice.propensity = kEpsilon / arm_count + (choice.candidate == greedy ? 1 - kEpsilon : 0);
  return choice;
}

Increment ThresholdsPolicy::LearnBailOut(uint32_t arm) {
  bailed_out_[arm] = true;
  return RewardPolicy::LearnBailOut(arm);
}

void ThresholdsPolicy::LearnDescriptor(const SceneDescriptor& descriptor, int64_t /*now_ns*/) {
  if (descriptor.object_count) object_count_ = descriptor.object_count;
  if (descriptor.density_ratio) density_ratio_ = *descriptor.density_ratio;
}

std::optional<uint32_t> ThresholdsPolicy::Find(std::string_view name) const {
  const auto found = std::find(arms_.begin(), arms_.end(), name);
  const auto arm = static_cast<uint32_t>(found - arms_.begin());
  if (found == arms_.end() || bailed_out_[arm]) return std::nullopt;
  return arm;
}

Choice ThresholdsPolicy::Choose(const ChoiceInput& input) const {
  if (!object_count_) return ChoiceOf(input.active_arm);
  for (const std::string_view name : RowOf(*object_count_, density_ratio_)) {
    if (const std::optional<uint32_t> arm = Find(name)) return ChoiceOf(*arm);
  }
  return ChoiceOf(input.active_arm);
}

LaneArgminPolicy::LaneArgminPolicy(const PolicySetup& setup)
    : RewardPolicy(setup),
      cooldown_ns_(std::min(setup.options.cooldown_ns,
                            setup.options.settling_ns + setup.options.decision_interval_ns)),
      log_costs_(setup.arms.size(), kUnseen),
      bailed_out_(setup.arms.size()) {}

Increment LaneArgminPolicy::LearnBailOut(uint32_t arm) {
  bailed_out_[arm] = true;
  return RewardPolicy::LearnBailOut(arm);
}

std::vector<Increment> LaneArgminPolicy::LearnShadow(std::span<const ShadowSample> samples,
                                                     int64_t /*now_ns*/) {
  for (const ShadowSample& sample : samples) {
    const double log_cost = LogCostOf(static_cast<double>(sample.detection_time_ns) * 1e-3);
    double& mean = log_costs_[sample.arm];
    mean = mean < kUnseen ? mean + kWeight * (log_cost - mean) : log_cost;
  }
  return {};
}

Choice LaneArgminPolicy::Choose(const ChoiceInput& input) const {
  uint32_t candidate = input.active_arm;
  double cheapest = bailed_out_[candidate] ? kUnseen : log_costs_[candidate] - kMargin;
  for (uint32_t arm = 0; arm < log_costs_.size(); ++arm) {
    if (bailed_out_[arm] || log_costs_[arm] >= cheapest) continue;
    cheapest = log_costs_[arm];
    candidate = arm;
  }
  return ChoiceOf(candidate);
}

}  // namespace sweepstake::decision
