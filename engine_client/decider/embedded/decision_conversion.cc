#include "engine_client/decider/embedded/decision_conversion.h"

#include <cmath>
#include <optional>

namespace sweepstake {

// The enumerations have the same values on both sides.
static_assert(static_cast<int>(DecisionOutcome::kHeldTie) ==
              static_cast<int>(decision::Outcome::kHeldTie));
static_assert(static_cast<int>(SwitchReason::kManual) ==
              static_cast<int>(decision::SwitchReason::kManual));
static_assert(static_cast<int>(Mode::kAi) == static_cast<int>(decision::Mode::kAi));
static_assert(static_cast<int>(Verdict::kDegraded) ==
              static_cast<int>(decision::Verdict::kDegraded));
static_assert(static_cast<int>(kFrameBailOut) == static_cast<int>(decision::kFrameBailOut));
static_assert(static_cast<int>(kShadowCapped) == static_cast<int>(decision::kShadowCapped));

decision::Frame ToDecision(const FrameSample& sample) {
  return {.frame_time_ns = sample.frame_time_ns,
          .detection_time_ns = sample.detection_time_ns,
          .aabb_check_count = sample.aabb_check_count,
          .native_bytes = sample.native_bytes,
          .object_count = sample.object_count,
          .arm = sample.arm,
          .switch_epoch = sample.switch_epoch,
          .flags = sample.flags};
}

decision::ShadowSample ToDecision(const ShadowSample& sample) {
  return {.first_frame_index = sample.first_frame_index,
          .detection_time_ns = sample.detection_time_ns,
          .build_time_ns = sample.build_time_ns,
          .aabb_check_count = sample.aabb_check_count,
          .native_bytes = sample.native_bytes,
          .arm = sample.arm,
          .object_count = sample.object_count,
          .frame_count = sample.frame_count,
          .flags = sample.flags};
}

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

decision::SwitchCost ToDecision(const SwitchOutcome& outcome) {
  decision::SwitchCost cost = {.rebuild_time_ns = outcome.rebuild_time_ns,
                               .settling_cost_ns = outcome.settling_cost_ns};
  if (outcome.trial_detection_time_ns > 0)
    cost.ended_trial = {.arm = outcome.trial_arm,
                        .detection_time_ns = outcome.trial_detection_time_ns};
  return cost;
}

decision::SwitchReason ToDecision(SwitchReason reason) {
  return static_cast<decision::SwitchReason>(reason);
}

decision::Mode ToDecision(Mode mode) { return static_cast<decision::Mode>(mode); }

decision::BetaPosterior ToDecision(const ArmBelief& belief) { return {belief.alpha, belief.beta}; }

SwitchCommand FromDecision(const decision::SwitchCommand& command) {
  return {.command_id = command.command_id,
          .arm = command.arm,
          .reason = static_cast<SwitchReason>(command.reason),
          .trial_limit_percent = command.trial_limit_percent};
}

SceneVerdict FromDecision(const decision::Diagnosis& diagnosis) {
  if (diagnosis.best_probability.empty()) return {};
  return {.verdict = static_cast<Verdict>(diagnosis.verdict),
          .leader_arm = diagnosis.leader,
          .leader_probability = diagnosis.best_probability[diagnosis.leader]};
}

ArmStanding FromDecision(const decision::ArmStanding& standing) {
  ArmStanding result{.live_window_count = standing.live_window_count,
                     .lane_visit_count = standing.lane_visit_count,
                     .effective_window_count = standing.effective_window_count,
                     .cost_ratio = {}};
  if (const auto& ratio = standing.cost_ratio)
    result.cost_ratio = CostRatio{.median = ratio->median, .low = ratio->low, .high = ratio->high};
  return result;
}

std::vector<ArmBelief> FromDecision(std::span<const decision::BetaPosterior> posteriors,
                                    std::span<const decision::ArmStanding> standings,
                                    const decision::Diagnosis& diagnosis,
                                    std::span<const std::string> arms) {
  std::vector<ArmBelief> beliefs;
  beliefs.reserve(posteriors.size());
  for (size_t arm = 0; arm < posteriors.size(); ++arm) {
    ArmBelief& belief =
        beliefs.emplace_back(ArmBelief{arms[arm], posteriors[arm].alpha, posteriors[arm].beta});
    if (diagnosis.best_probability.empty()) continue;
    belief.standing = FromDecision(standings[arm]);
    belief.standing->best_probability = diagnosis.best_probability[arm];
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
  event.outcome = static_cast<DecisionOutcome>(record.outcome);
  if (decision.command) event.command = FromDecision(*decision.command);
  event.reward = record.reward;
  event.beliefs = FromDecision(record.posteriors, record.standings, record.diagnosis, arms);
  event.best_probability = record.diagnosis.best_probability;
  event.expected_loss_ratio = record.diagnosis.expected_loss_ratio;
  event.verdict = FromDecision(record.diagnosis);
  return event;
}

}  // namespace sweepstake
