#include "engine_client/telemetry/wire.h"

namespace sweepstake {

v1::SceneDescriptor ToWire(const SceneDescriptor& descriptor) {
  v1::SceneDescriptor wire;
  if (descriptor.object_count >= 0) wire.set_object_count(descriptor.object_count);
  if (descriptor.density_ratio >= 0) wire.set_density_ratio(descriptor.density_ratio);
  if (descriptor.size_spread >= 0) wire.set_size_spread(descriptor.size_spread);
  if (descriptor.speed_mean >= 0) wire.set_speed_mean(descriptor.speed_mean);
  if (descriptor.speed_spread >= 0) wire.set_speed_spread(descriptor.speed_spread);
  if (descriptor.clustering_ratio >= 0) wire.set_clustering_ratio(descriptor.clustering_ratio);
  if (descriptor.static_ratio >= 0) wire.set_static_ratio(descriptor.static_ratio);
  return wire;
}

v1::ShadowSample ToWire(const ShadowSample& sample) {
  v1::ShadowSample wire;
  wire.set_first_frame_index(sample.first_frame_index);
  wire.set_arm(sample.arm);
  wire.set_detection_time_ns(sample.detection_time_ns);
  wire.set_build_time_ns(sample.build_time_ns);
  wire.set_aabb_check_count(sample.aabb_check_count);
  wire.set_native_bytes(sample.native_bytes);
  wire.set_object_count(sample.object_count);
  wire.set_frame_count(sample.frame_count);
  wire.set_flags(sample.flags);
  return wire;
}

v1::StreamTelemetryRequest ToRequest(const SwitchOutcome& outcome) {
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& wire = *request.mutable_switch_outcome();
  wire.set_command_id(outcome.command_id);
  wire.set_arm(outcome.arm);
  wire.set_switch_epoch(outcome.switch_epoch);
  wire.set_executed(outcome.executed != 0);
  wire.set_rebuild_time_ns(outcome.rebuild_time_ns);
  wire.set_settling_cost_ns(outcome.settling_cost_ns);
  wire.set_reason(static_cast<v1::SwitchReason>(outcome.reason));
  if (outcome.executed == 0) {
    wire.set_error("refused: the arm was active already, or the game was choosing for itself");
  }
  return request;
}

v1::StreamTelemetryRequest ToRequest(const ModeNote& change) {
  v1::StreamTelemetryRequest request;
  v1::ModeChange& wire = *request.mutable_mode_change();
  wire.set_mode(static_cast<v1::Mode>(change.mode));
  wire.set_active_arm(change.active_arm);
  return request;
}

v1::StreamTelemetryRequest BailOutRequest(const FrameSample& sample) {
  v1::StreamTelemetryRequest request;
  v1::BailOut& wire = *request.mutable_bail_out();
  wire.set_frame_index(sample.frame_index);
  wire.set_arm(sample.arm);
  wire.set_switch_epoch(sample.switch_epoch);
  wire.set_frame_time_ns(sample.frame_time_ns);
  wire.set_detection_time_ns(sample.detection_time_ns);
  wire.set_flags(sample.flags);
  return request;
}

v1::StreamTelemetryRequest RefusalRequest(const v1::SwitchCommand& command, uint32_t active_arm,
                                          uint32_t switch_epoch) {
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& wire = *request.mutable_switch_outcome();
  wire.set_command_id(command.command_id());
  wire.set_arm(active_arm);
  wire.set_switch_epoch(switch_epoch);
  wire.set_executed(false);
  wire.set_reason(command.reason());
  wire.set_error("this session has no arm " + std::to_string(command.arm()));
  return request;
}

}  // namespace sweepstake
