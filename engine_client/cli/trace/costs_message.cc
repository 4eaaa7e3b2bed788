#include "engine_client/cli/trace/costs_message.h"

#include "engine_client/telemetry/proto_conversion.h"

namespace sweepstake::cli {
namespace {

template <typename Repeated, typename Number>
void Put(const std::vector<Number>& column, Repeated& repeated) {
  repeated.Assign(column.begin(), column.end());
}

template <typename Number, typename Repeated>
std::vector<Number> Take(const Repeated& repeated) {
  return {repeated.begin(), repeated.end()};
}

void PutColumns(const CostTrace& trace, costs::CostTrace& message) {
  Put(trace.object_count, *message.mutable_object_count());
  Put(trace.pair_count, *message.mutable_pair_count());
  Put(trace.step_ns, *message.mutable_step_ns());
  Put(trace.control_ns, *message.mutable_control_ns());
  Put(trace.detection_ns, *message.mutable_detection_ns());
  Put(trace.aabb_check_count, *message.mutable_aabb_check_count());
  Put(trace.native_bytes, *message.mutable_native_bytes());
  message.set_held(std::string(trace.held.begin(), trace.held.end()));
}

void TakeColumns(const costs::CostTrace& message, CostTrace& trace) {
  trace.object_count = Take<uint32_t>(message.object_count());
  trace.pair_count = Take<uint32_t>(message.pair_count());
  trace.step_ns = Take<uint64_t>(message.step_ns());
  trace.control_ns = Take<uint64_t>(message.control_ns());
  trace.detection_ns = Take<uint64_t>(message.detection_ns());
  trace.aabb_check_count = Take<uint64_t>(message.aabb_check_count());
  trace.native_bytes = Take<uint64_t>(message.native_bytes());
  trace.held = Take<uint8_t>(message.held());
}

}  // namespace

costs::CostTrace ToProto(const CostTrace& trace) {
  costs::CostTrace message;
  message.set_scene(trace.scene);
  message.set_seed(trace.seed);
  message.set_machine(trace.machine);
  message.set_frame_count(trace.frame_count);
  message.set_repeat_count(trace.repeat_count);
  message.set_control_arm(trace.control_arm);
  message.set_burst_frame_count(trace.burst_frame_count);
  for (const TracedArm& arm : trace.arms) {
    costs::TracedArm& wire = *message.add_arms();
    wire.set_name(arm.name);
    wire.set_version(arm.version);
  }
  PutColumns(trace, message);
  for (const TraceBurst& burst : trace.bursts) {
    costs::TraceBurst& wire = *message.add_bursts();
    wire.set_first_frame(burst.first_frame);
    Put(burst.detection_ns, *wire.mutable_detection_ns());
  }
  for (const TracedDescriptor& traced : trace.descriptors) {
    costs::TracedDescriptor& wire = *message.add_descriptors();
    wire.set_frame(traced.frame);
    *wire.mutable_scene_descriptor() = sweepstake::ToProto(traced.descriptor);
  }
  return message;
}

CostTrace FromProto(const costs::CostTrace& message) {
  CostTrace trace;
  trace.scene = message.scene();
  trace.seed = message.seed();
  trace.machine = message.machine();
  trace.frame_count = message.frame_count();
  trace.repeat_count = message.repeat_count();
  trace.control_arm = message.control_arm();
  trace.burst_frame_count = message.burst_frame_count();
  for (const costs::TracedArm& arm : message.arms()) {
    trace.arms.push_back({arm.name(), arm.version()});
  }
  TakeColumns(message, trace);
  for (const costs::TraceBurst& burst : message.bursts()) {
    trace.bursts.push_back({burst.first_frame(), Take<uint64_t>(burst.detection_ns())});
  }
  for (const costs::TracedDescriptor& traced : message.descriptors()) {
    trace.descriptors.push_back({traced.frame(), sweepstake::FromProto(traced.scene_descriptor())});
  }
  return trace;
}

}  // namespace sweepstake::cli
