#include "engine_client/decider/embedded/decision_conversion.h"

#include <cmath>
#include <optional>

namespace sweepstake {

decision::SceneDescriptor ToDecision(const SceneDescriptor& descriptor) {
  const auto measured = [](float value) -> std::optional<double> {
    if (!std::isfinite(value) || value < 0) return std::nullopt;
    return value;
  };
  return {.object_count = measured(descriptor.object_count),
          .density_ratio = measured(descriptor.density_ratio),
          .size_spread = measured(descriptor.size_spread),
          .speed_mean = measured(descriptor.speed_mean),
          .speed_spread = measured(descriptor.speed_spread),
          .clustering_ratio = measured(descriptor.clustering_ratio),
          .static_ratio = measured(descriptor.static_ratio)};
}

decision::SwitchCost SwitchCostOf(const SwitchOutcome& outcome) {
  decision::SwitchCost cost = {.rebuild_time_ns = outcome.rebuild_time_ns,
                               .settling_cost_ns = outcome.settling_cost_ns};
  if (outcome.trial_detection_time_ns > 0)
    cost.ended_trial = {.arm = outcome.trial_arm,
                        .detection_time_ns = outcome.trial_detection_time_ns};
  return cost;
}

SceneVerdict FromDecision(const decision::Diagnosis& diagnosis) {
  if (diagnosis.best_probability.empty()) return {};
  return {.verdict = diagnosis.verdict,
          .leader_arm = diagnosis.leader,
          .leader_probability = diagnosis.best_probability[diagnosis.leader]};
}

std::vector<ArmBelief> FromDecision(std::span<const decision::BetaPosterior> posteriors,
                                    std::span<const ArmStanding> standings,
                                    const decision::Diagnosis& diagnosis,
                                    std::span<const std::string> arms) {
  std::vector<ArmBelief> beliefs;
  beliefs.reserve(posteriors.size());
  for (size_t arm = 0; arm < posteriors.size(); ++arm) {
    ArmBelief& belief =
        beliefs.emplace_back(ArmBelief{arms[arm], posteriors[arm].alpha, posteriors[arm].beta});
    if (!diagnosis.best_probability.empty()) belief.standing = standings[arm];
  }
  return beliefs;
}

DecisionEvent FromDecision(const decision::Decision& decision, std::span<const std::string> arms) {
  const decision::DecisionRecord& record = decision.record;
  DecisionEvent event;
  event.decision_id = record.decision_id;
  event.time_ns = static_cast<uint64_t>(record.time_ns);
  event.active_arm = record.active_arm;
  event.candidate_arm = record.candidate;
  event.outcome = record.outcome;
  event.command = decision.command;
  event.reward = record.reward;
  event.beliefs = FromDecision(record.posteriors, record.standings, record.diagnosis, arms);
  event.best_probability = record.diagnosis.best_probability;
  event.expected_loss_ratio = record.diagnosis.expected_loss_ratio;
  event.verdict = FromDecision(record.diagnosis);
  return event;
}

}  // namespace sweepstake
