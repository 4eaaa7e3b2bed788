#include "engine_client/telemetry/proto_conversion.h"

#include <cmath>
#include <utility>

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

v1::ShadowSample ToProto(const ShadowSample& sample) {
  v1::ShadowSample message;
  message.set_first_frame_index(sample.first_frame_index);
  message.set_arm(sample.arm);
  message.set_detection_time_ns(sample.detection_time_ns);
  message.set_build_time_ns(sample.build_time_ns);
  message.set_aabb_check_count(sample.aabb_check_count);
  message.set_native_bytes(sample.native_bytes);
  message.set_object_count(sample.object_count);
  message.set_frame_count(sample.frame_count);
  message.set_flags(sample.flags);
  return message;
}

void ToProto(const FrameSample& sample, v1::FrameBatch& batch) {
  batch.add_frame_time_ns(sample.frame_time_ns);
  batch.add_detection_time_ns(sample.detection_time_ns);
  batch.add_aabb_check_count(sample.aabb_check_count);
  batch.add_native_bytes(sample.native_bytes);
  batch.add_object_count(sample.object_count);
  batch.add_arm(sample.arm);
  batch.add_switch_epoch(sample.switch_epoch);
  batch.add_flags(sample.flags);
}

v1::StreamTelemetryRequest ToProto(const SwitchOutcome& outcome) {
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& message = *request.mutable_switch_outcome();
  message.set_command_id(outcome.command_id);
  message.set_arm(outcome.arm);
  message.set_switch_epoch(outcome.switch_epoch);
  message.set_executed(outcome.executed != 0);
  message.set_rebuild_time_ns(outcome.rebuild_time_ns);
  message.set_settling_cost_ns(outcome.settling_cost_ns);
  message.set_reason(static_cast<v1::SwitchReason>(outcome.reason));
  return request;
}

v1::StreamTelemetryRequest ToProto(const ModeChange& change) {
  v1::StreamTelemetryRequest request;
  v1::ModeChange& message = *request.mutable_mode_change();
  message.set_mode(ToProto(change.mode));
  message.set_active_arm(change.active_arm);
  message.set_order_id(change.order_id);
  return request;
}

v1::StreamTelemetryRequest BailOutToProto(const FrameSample& sample) {
  v1::StreamTelemetryRequest request;
  v1::BailOut& message = *request.mutable_bail_out();
  message.set_frame_index(sample.frame_index);
  message.set_arm(sample.arm);
  message.set_switch_epoch(sample.switch_epoch);
  message.set_frame_time_ns(sample.frame_time_ns);
  message.set_detection_time_ns(sample.detection_time_ns);
  message.set_flags(sample.flags);
  return request;
}

v1::StreamTelemetryRequest RefusalToProto(const v1::SwitchCommand& command, uint32_t active_arm,
                                          uint32_t switch_epoch) {
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& message = *request.mutable_switch_outcome();
  message.set_command_id(command.command_id());
  message.set_arm(active_arm);
  message.set_switch_epoch(switch_epoch);
  message.set_executed(false);
  message.set_reason(command.reason());
  return request;
}

v1::StreamTelemetryRequest RefusalToProto(const v1::OperatorOrder& order,
                                          v1::OrderRefusalReason reason) {
  v1::StreamTelemetryRequest request;
  request.mutable_order_refusal()->set_order_id(order.order_id());
  request.mutable_order_refusal()->set_reason(reason);
  return request;
}

std::optional<SwitchCommand> FromProto(const v1::SwitchCommand& message) {
  if (message.reason() < v1::SWITCH_REASON_POLICY || message.reason() > v1::SWITCH_REASON_MANUAL) {
    return std::nullopt;
  }
  return SwitchCommand{.command_id = message.command_id(),
                       .arm = message.arm(),
                       .reason = static_cast<SwitchReason>(message.reason())};
}

std::optional<OperatorOrder> FromProto(const v1::OperatorOrder& message, size_t arm_count) {
  if (message.mode() != v1::MODE_MANUAL && message.mode() != v1::MODE_AI) return std::nullopt;
  if (message.has_arm() && message.arm() >= arm_count) return std::nullopt;
  return OperatorOrder{.order_id = message.order_id(),
                       .mode = static_cast<Mode>(message.mode()),
                       .arm = message.has_arm() ? std::optional(message.arm()) : std::nullopt};
}

std::optional<SceneVerdict> FromProto(const v1::PosteriorSnapshot& message, size_t arm_count) {
  const double probability = message.leader_probability();
  if (message.leader_arm() >= arm_count || !(probability >= 0 && probability <= 1) ||
      message.verdict() < v1::VERDICT_UNSPECIFIED || message.verdict() > v1::VERDICT_DEGRADED) {
    return std::nullopt;
  }
  return SceneVerdict{.verdict = static_cast<Verdict>(message.verdict()),
                      .leader_arm = message.leader_arm(),
                      .leader_probability = probability};
}

v1::Mode ToProto(Mode mode) { return static_cast<v1::Mode>(mode); }

std::optional<ArmBelief> FromProto(const v1::BetaPosterior& posterior, const std::string& arm) {
  const double alpha = posterior.alpha();
  const double beta = posterior.beta();
  if (!std::isfinite(alpha) || !std::isfinite(beta) || alpha <= 0 || beta <= 0) return std::nullopt;
  return ArmBelief{arm, alpha, beta};
}

std::optional<std::vector<ArmBelief>> FromProto(
    const google::protobuf::RepeatedPtrField<v1::BetaPosterior>& posteriors,
    std::span<const std::string> arms) {
  if (static_cast<size_t>(posteriors.size()) != arms.size()) return std::nullopt;
  std::vector<ArmBelief> beliefs;
  for (const v1::BetaPosterior& posterior : posteriors) {
    auto belief = FromProto(posterior, arms[beliefs.size()]);
    if (!belief) return std::nullopt;
    beliefs.push_back(*std::move(belief));
  }
  return beliefs;
}

v1::PriorRecord ToProto(const PriorRecord& record) {
  v1::PriorRecord message;
  message.set_project(record.project);
  message.set_scene(record.scene);
  message.set_context_bucket(record.context_bucket);
  message.set_arm(record.arm);
  message.set_backend_version(record.backend_version);
  message.set_machine_class(record.machine_class);
  message.set_reward_version(record.reward_version);
  message.set_source_id(record.source_id);
  message.set_source_sequence(record.source_sequence);
  message.set_alpha_increment(record.alpha_increment);
  message.set_beta_increment(record.beta_increment);
  message.set_window_count(record.window_count);
  message.set_bail_out_count(record.bail_out_count);
  return message;
}

PriorRecord FromProto(const v1::PriorRecord& message) {
  return {.project = message.project(),
          .scene = message.scene(),
          .context_bucket = message.context_bucket(),
          .arm = message.arm(),
          .backend_version = message.backend_version(),
          .machine_class = message.machine_class(),
          .reward_version = message.reward_version(),
          .source_id = message.source_id(),
          .source_sequence = message.source_sequence(),
          .alpha_increment = message.alpha_increment(),
          .beta_increment = message.beta_increment(),
          .window_count = message.window_count(),
          .bail_out_count = message.bail_out_count()};
}

}  // namespace sweepstake
