#include "engine_client/telemetry/conversion/proto_conversion.h"

#include <cmath>

namespace sweepstake {
v1::SceneDescriptor ToProto(const SceneDescriptor& descriptor) {
  v1::SceneDescriptor message;
  if (descriptor.object_count >= 0) message.set_object_count(descriptor.object_count);
  if (descriptor.density_ratio >= 0) message.set_density_ratio(descriptor.density_ratio);
  if (descriptor.size_spread >= 0) message.set_size_spread(descriptor.size_spread);
  if (descriptor.speed_mean >= 0) message.set_speed_mean(descriptor.speed_mean);
  if (descriptor.speed_spread >= 0) message.set_speed_spread(descriptor.speed_spread);
  if (descriptor.clustering_ratio >= 0) message.set_clustering_ratio(descriptor.clustering_ratio);
  if (descriptor.static_ratio >= 0) message.set_static_ratio(descriptor.static_ratio);
  return message;
}

SceneDescriptor FromProto(const v1::SceneDescriptor& message) {
  SceneDescriptor descriptor;
  if (message.has_object_count()) descriptor.object_count = message.object_count();
  if (message.has_density_ratio()) descriptor.density_ratio = message.density_ratio();
  if (message.has_size_spread()) descriptor.size_spread = message.size_spread();
  if (message.has_speed_mean()) descriptor.speed_mean = message.speed_mean();
  if (message.has_speed_spread()) descriptor.speed_spread = message.speed_spread();
  if (message.has_clustering_ratio()) descriptor.clustering_ratio = message.clustering_ratio();
  if (message.has_static_ratio()) descriptor.static_ratio = message.static_ratio();
  return descriptor;
}

std::optional<ArmBelief> FromProto(const v1::BetaPosterior& posterior, const std::string& arm) {
  const double alpha = posterior.alpha();
  const double beta = posterior.beta();
  if (!std::isfinite(alpha) || !std::isfinite(beta) || alpha <= 0 || beta <= 0) return std::nullopt;
  return ArmBelief{arm, alpha, beta};
}

void ToProto(const CostRatio& ratio, v1::CostRatio& message) {
  message.set_median(ratio.median);
  message.set_low(ratio.low);
  message.set_high(ratio.high);
}

v1::ArmStanding ToProto(const ArmStanding& standing) {
  v1::ArmStanding message;
  message.set_live_window_count(standing.live_window_count);
  message.set_lane_visit_count(standing.lane_visit_count);
  message.set_effective_window_count(standing.effective_window_count);
  message.set_best_probability(standing.best_probability);
  if (standing.cost_ratio) ToProto(*standing.cost_ratio, *message.mutable_cost_ratio());
  return message;
}

ArmStanding FromProto(const v1::ArmStanding& standing) {
  ArmStanding result{.live_window_count = standing.live_window_count(),
                     .lane_visit_count = standing.lane_visit_count(),
                     .effective_window_count = standing.effective_window_count(),
                     .best_probability = standing.best_probability(),
                     .cost_ratio = {}};
  if (standing.has_cost_ratio()) {
    const v1::CostRatio& ratio = standing.cost_ratio();
    result.cost_ratio =
        CostRatio{.median = ratio.median(), .low = ratio.low(), .high = ratio.high()};
  }
  return result;
}

v1::PriorRecord ToProto(const PriorRecord& record) {
  v1::PriorRecord message;
  message.set_project(record.key.project);
  message.set_scene(record.key.scene);
  message.set_measured_by(record.key.measured_by);
  message.set_arm(record.key.arm);
  message.set_backend_version(record.key.backend_version);
  message.set_machine_class(record.key.machine_class);
  message.set_reward_version(record.key.reward_version);
  message.set_regime(record.key.regime);
  message.set_source_id(record.source_id);
  message.set_source_sequence(record.source_sequence);
  message.set_alpha_increment(record.evidence.alpha);
  message.set_beta_increment(record.evidence.beta);
  message.set_window_count(record.evidence.window_count);
  message.set_bail_out_count(record.evidence.bail_out_count);
  message.set_build(record.build);
  message.set_unix_last_seen_s(static_cast<int64_t>(record.last_seen_unix_s));
  message.set_is_imported(record.is_imported);
  message.set_is_quarantined(record.is_quarantined);
  return message;
}

PriorRecord FromProto(const v1::PriorRecord& message) {
  return {.key = {.project = message.project(),
                  .scene = message.scene(),
                  .measured_by = message.measured_by(),
                  .arm = message.arm(),
                  .backend_version = message.backend_version(),
                  .machine_class = message.machine_class(),
                  .reward_version = message.reward_version(),
                  .regime = message.regime()},
          .source_id = message.source_id(),
          .source_sequence = message.source_sequence(),
          .evidence = {.alpha = message.alpha_increment(),
                       .beta = message.beta_increment(),
                       .window_count = message.window_count(),
                       .bail_out_count = message.bail_out_count()},
          .build = message.build(),
          .last_seen_unix_s = static_cast<uint64_t>(message.unix_last_seen_s()),
          .is_quarantined = message.is_quarantined()};
}

bool IsChanging(const v1::ScenePosterior& scene) {
  return scene.has_activity() ? scene.activity().is_changing() : scene.regime_arms_size() > 1;
}

}  // namespace sweepstake
