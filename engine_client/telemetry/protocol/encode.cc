// Encodes messages. The tags are the field numbers of telemetry.proto. tests/wire_fields_test.py
// checks that the code writes each field by the name of its tag.
#include <protozero/pbf_builder.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake::protocol {
namespace {

using protozero::pbf_builder;
using Number = protozero::pbf_tag_type;

enum class StreamTelemetryRequestTag : Number {
  kSequence = 1,
  kHello = 2,
  kFrameBatch = 3,
  kSwitchOutcome = 4,
  kBailOut = 5,
  kModeChange = 6,
  kGoodbye = 7,
  kOrderRefusal = 8,
  kBoxView = 9
};
enum class ArmTag : Number { kName = 1, kBackendVersion = 2 };
enum class HelloTag : Number {
  kProtocolVersion = 1,
  kProject = 2,
  kScene = 3,
  kBuild = 4,
  kMachineClass = 5,
  kArms = 6,
  kActiveArm = 7,
  kMode = 8,
  kSessionId = 9,
  kTimeScale = 10,
  kIgnorePriors = 11,
  kSeed = 12,
  kPolicy = 13,
  kSwitchEpoch = 14,
  kResumeToken = 15,
  kCapabilities = 16
};
enum class FrameBatchTag : Number {
  kFrameTimeNs = 1,
  kDetectionTimeNs = 2,
  kAabbCheckCount = 3,
  kNativeBytes = 4,
  kObjectCount = 5,
  kArm = 6,
  kSwitchEpoch = 7,
  kFlags = 8,
  kSceneDescriptor = 9,
  kDroppedFrameCount = 10,
  kShadowSamples = 11
};
enum class ShadowSampleTag : Number {
  kFirstFrameIndex = 1,
  kArm = 2,
  kDetectionTimeNs = 3,
  kBuildTimeNs = 4,
  kAabbCheckCount = 5,
  kNativeBytes = 6,
  kObjectCount = 7,
  kFrameCount = 8,
  kFlags = 9
};
enum class SceneDescriptorTag : Number {
  kObjectCount = 1,
  kDensityRatio = 2,
  kSizeSpread = 3,
  kSpeedMean = 4,
  kSpeedSpread = 5,
  kClusteringRatio = 6,
  kStaticRatio = 7
};
enum class SwitchOutcomeTag : Number {
  kCommandId = 1,
  kArm = 2,
  kSwitchEpoch = 3,
  kExecuted = 4,
  kRebuildTimeNs = 5,
  kSettlingCostNs = 6,
  kReason = 7,
  kTrialDetectionTimeNs = 8,
  kTrialArm = 9
};
enum class BailOutTag : Number {
  kFrameIndex = 1,
  kArm = 2,
  kSwitchEpoch = 3,
  kFrameTimeNs = 4,
  kDetectionTimeNs = 5,
  kFlags = 6
};
enum class ModeChangeTag : Number { kMode = 1, kActiveArm = 2, kOrderId = 3 };
enum class OrderRefusalTag : Number { kOrderId = 1, kReason = 2 };
enum class BoxViewTag : Number {
  kFrameIndex = 1,
  kObjectCount = 2,
  kStride = 3,
  kBounds = 4,
  kBoxes = 5,
  kPairs = 6
};

// Collects the fields of one message. As in proto3, a field with its default value is omitted, but
// an embedded message is written even if it is empty.
template <typename Tag>
class Writer {
 public:
  // Writes an integer, an enumeration or a bool as a varint.
  template <typename Value>
  void PutNumber(Tag tag, Value value) {
    if (const auto number = static_cast<uint64_t>(value); number != 0)
      builder_.add_uint64(tag, number);
  }
  void PutDouble(Tag tag, double value) {
    if (value != 0) builder_.add_double(tag, value);
  }
  void PutText(Tag tag, const std::string& text) {
    if (!text.empty()) builder_.add_bytes(tag, text);
  }
  // Writes a property of the scene. A negative value was not measured and is omitted.
  void PutProperty(Tag tag, float value) {
    if (value >= 0) builder_.add_float(tag, value);
  }
  // Writes one member of all frames as a packed field.
  template <typename Member>
  void PutColumn(Tag tag, const std::vector<FrameSample>& frames, Member FrameSample::*member) {
    if (frames.empty()) return;
    protozero::packed_field_uint64 column(builder_, static_cast<Number>(tag));
    for (const FrameSample& frame : frames) column.add_element(frame.*member);
  }

  void PutNumbers(Tag tag, const std::vector<Capability>& values) {
    if (values.empty()) return;
    protozero::packed_field_uint64 column(builder_, static_cast<Number>(tag));
    for (const Capability value : values) column.add_element(static_cast<uint64_t>(value));
  }
  void PutFloats(Tag tag, const std::vector<float>& values) {
    if (values.empty()) return;
    protozero::packed_field_float column(builder_, static_cast<Number>(tag));
    for (const float value : values) column.add_element(value);
  }
  void PutMessage(Tag tag, const std::string& message) { builder_.add_message(tag, message); }

  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  pbf_builder<Tag> builder_{bytes_};
};

std::string Request(StreamTelemetryRequestTag tag, const std::string& message) {
  Writer<StreamTelemetryRequestTag> out;
  out.PutMessage(tag, message);
  return out.Take();
}

std::string BytesOf(const Arm& arm) {
  Writer<ArmTag> out;
  out.PutText(ArmTag::kName, arm.name);
  out.PutNumber(ArmTag::kBackendVersion, arm.backend_version);
  return out.Take();
}

std::string BytesOf(const SceneDescriptor& descriptor) {
  Writer<SceneDescriptorTag> out;
  out.PutProperty(SceneDescriptorTag::kObjectCount, descriptor.object_count);
  out.PutProperty(SceneDescriptorTag::kDensityRatio, descriptor.density_ratio);
  out.PutProperty(SceneDescriptorTag::kSizeSpread, descriptor.size_spread);
  out.PutProperty(SceneDescriptorTag::kSpeedMean, descriptor.speed_mean);
  out.PutProperty(SceneDescriptorTag::kSpeedSpread, descriptor.speed_spread);
  out.PutProperty(SceneDescriptorTag::kClusteringRatio, descriptor.clustering_ratio);
  out.PutProperty(SceneDescriptorTag::kStaticRatio, descriptor.static_ratio);
  return out.Take();
}

std::string BytesOf(const ShadowSample& sample) {
  Writer<ShadowSampleTag> out;
  out.PutNumber(ShadowSampleTag::kFirstFrameIndex, sample.first_frame_index);
  out.PutNumber(ShadowSampleTag::kArm, sample.arm);
  out.PutNumber(ShadowSampleTag::kDetectionTimeNs, sample.detection_time_ns);
  out.PutNumber(ShadowSampleTag::kBuildTimeNs, sample.build_time_ns);
  out.PutNumber(ShadowSampleTag::kAabbCheckCount, sample.aabb_check_count);
  out.PutNumber(ShadowSampleTag::kNativeBytes, sample.native_bytes);
  out.PutNumber(ShadowSampleTag::kObjectCount, sample.object_count);
  out.PutNumber(ShadowSampleTag::kFrameCount, sample.frame_count);
  out.PutNumber(ShadowSampleTag::kFlags, sample.flags);
  return out.Take();
}

}  // namespace

std::string Encode(const Hello& hello) {
  Writer<HelloTag> out;
  out.PutNumber(HelloTag::kProtocolVersion, hello.protocol_version);
  out.PutText(HelloTag::kProject, hello.project);
  out.PutText(HelloTag::kScene, hello.scene);
  out.PutText(HelloTag::kBuild, hello.build);
  out.PutText(HelloTag::kMachineClass, hello.machine_class);
  for (const Arm& arm : hello.arms) out.PutMessage(HelloTag::kArms, BytesOf(arm));
  out.PutNumber(HelloTag::kActiveArm, hello.active_arm);
  out.PutNumber(HelloTag::kMode, hello.mode);
  out.PutText(HelloTag::kSessionId, hello.session_id);
  out.PutDouble(HelloTag::kTimeScale, hello.time_scale);
  out.PutNumber(HelloTag::kIgnorePriors, hello.ignore_priors);
  out.PutNumber(HelloTag::kSeed, hello.seed);
  out.PutText(HelloTag::kPolicy, hello.policy);
  out.PutNumber(HelloTag::kSwitchEpoch, hello.switch_epoch);
  out.PutText(HelloTag::kResumeToken, hello.resume_token);
  out.PutNumbers(HelloTag::kCapabilities, hello.capabilities);
  return Request(StreamTelemetryRequestTag::kHello, out.Take());
}

std::string Encode(const FrameBatch& batch) {
  Writer<FrameBatchTag> out;
  out.PutColumn(FrameBatchTag::kFrameTimeNs, batch.frames, &FrameSample::frame_time_ns);
  out.PutColumn(FrameBatchTag::kDetectionTimeNs, batch.frames, &FrameSample::detection_time_ns);
  out.PutColumn(FrameBatchTag::kAabbCheckCount, batch.frames, &FrameSample::aabb_check_count);
  out.PutColumn(FrameBatchTag::kNativeBytes, batch.frames, &FrameSample::native_bytes);
  out.PutColumn(FrameBatchTag::kObjectCount, batch.frames, &FrameSample::object_count);
  out.PutColumn(FrameBatchTag::kArm, batch.frames, &FrameSample::arm);
  out.PutColumn(FrameBatchTag::kSwitchEpoch, batch.frames, &FrameSample::switch_epoch);
  out.PutColumn(FrameBatchTag::kFlags, batch.frames, &FrameSample::flags);
  if (batch.scene_descriptor)
    out.PutMessage(FrameBatchTag::kSceneDescriptor, BytesOf(*batch.scene_descriptor));
  out.PutNumber(FrameBatchTag::kDroppedFrameCount, batch.dropped_frame_count);
  for (const ShadowSample& sample : batch.shadow_samples)
    out.PutMessage(FrameBatchTag::kShadowSamples, BytesOf(sample));
  return Request(StreamTelemetryRequestTag::kFrameBatch, out.Take());
}

std::string Encode(const SwitchOutcome& outcome) {
  Writer<SwitchOutcomeTag> out;
  out.PutNumber(SwitchOutcomeTag::kCommandId, outcome.command_id);
  out.PutNumber(SwitchOutcomeTag::kArm, outcome.arm);
  out.PutNumber(SwitchOutcomeTag::kSwitchEpoch, outcome.switch_epoch);
  out.PutNumber(SwitchOutcomeTag::kExecuted, outcome.executed != 0);
  out.PutNumber(SwitchOutcomeTag::kRebuildTimeNs, outcome.rebuild_time_ns);
  out.PutNumber(SwitchOutcomeTag::kSettlingCostNs, outcome.settling_cost_ns);
  out.PutNumber(SwitchOutcomeTag::kReason, outcome.reason);
  out.PutNumber(SwitchOutcomeTag::kTrialDetectionTimeNs, outcome.trial_detection_time_ns);
  out.PutNumber(SwitchOutcomeTag::kTrialArm, outcome.trial_arm);
  return Request(StreamTelemetryRequestTag::kSwitchOutcome, out.Take());
}

std::string Encode(const BailOut& bail_out) {
  Writer<BailOutTag> out;
  out.PutNumber(BailOutTag::kFrameIndex, bail_out.frame.frame_index);
  out.PutNumber(BailOutTag::kArm, bail_out.frame.arm);
  out.PutNumber(BailOutTag::kSwitchEpoch, bail_out.frame.switch_epoch);
  out.PutNumber(BailOutTag::kFrameTimeNs, bail_out.frame.frame_time_ns);
  out.PutNumber(BailOutTag::kDetectionTimeNs, bail_out.frame.detection_time_ns);
  out.PutNumber(BailOutTag::kFlags, bail_out.frame.flags);
  return Request(StreamTelemetryRequestTag::kBailOut, out.Take());
}

std::string Encode(const ModeChange& change) {
  Writer<ModeChangeTag> out;
  out.PutNumber(ModeChangeTag::kMode, change.mode);
  out.PutNumber(ModeChangeTag::kActiveArm, change.active_arm);
  out.PutNumber(ModeChangeTag::kOrderId, change.order_id);
  return Request(StreamTelemetryRequestTag::kModeChange, out.Take());
}

std::string Encode(const Goodbye& /*goodbye*/) {
  return Request(StreamTelemetryRequestTag::kGoodbye, "");
}

std::string Encode(const OrderRefusal& refusal) {
  Writer<OrderRefusalTag> out;
  out.PutNumber(OrderRefusalTag::kOrderId, refusal.order_id);
  out.PutNumber(OrderRefusalTag::kReason, refusal.reason);
  return Request(StreamTelemetryRequestTag::kOrderRefusal, out.Take());
}

std::string Encode(const BoxView& view) {
  Writer<BoxViewTag> out;
  out.PutNumber(BoxViewTag::kFrameIndex, view.frame_index);
  out.PutNumber(BoxViewTag::kObjectCount, view.object_count);
  out.PutNumber(BoxViewTag::kStride, view.stride);
  out.PutFloats(BoxViewTag::kBounds, view.bounds);
  out.PutText(BoxViewTag::kBoxes, view.boxes);
  out.PutText(BoxViewTag::kPairs, view.pairs);
  return Request(StreamTelemetryRequestTag::kBoxView, out.Take());
}

std::string Numbered(uint64_t sequence, std::string_view encoded) {
  Writer<StreamTelemetryRequestTag> out;
  out.PutNumber(StreamTelemetryRequestTag::kSequence, sequence);
  return out.Take().append(encoded);
}

}  // namespace sweepstake::protocol
