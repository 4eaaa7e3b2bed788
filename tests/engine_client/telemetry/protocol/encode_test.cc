// Compares the client's encoder with protobuf byte by byte: each message with each of its fields.
#include <gtest/gtest.h>

#include "engine_client/telemetry/conversion/proto_conversion.h"
#include "engine_client/telemetry/protocol/wire.h"
#include "sweepstake/v1/telemetry.pb.h"
#include "tests/engine_client/telemetry/protocol/random_messages.h"

namespace sweepstake::protocol {
namespace {

using google::protobuf::FieldDescriptor;

Hello PlainOf(const v1::Hello& message) {
  Hello hello{.protocol_version = message.protocol_version(),
              .project = message.project(),
              .scene = message.scene(),
              .build = message.build(),
              .machine_class = message.machine_class(),
              .arms = {},
              .active_arm = message.active_arm(),
              .mode = static_cast<Mode>(message.mode()),
              .session_id = message.session_id(),
              .time_scale = message.time_scale(),
              .ignore_priors = message.ignore_priors(),
              .seed = message.seed(),
              .policy = message.policy(),
              .switch_epoch = message.switch_epoch(),
              .resume_token = message.resume_token(),
              .capabilities = {},
              .rules = {}};
  if (message.has_weights()) {
    const v1::RewardWeights& weights = message.weights();
    hello.rules.weights = {weights.fps(), weights.detection(), weights.memory(), weights.checks()};
  }
  if (message.has_decision_interval_ns())
    hello.rules.decision_interval_ns = message.decision_interval_ns();
  if (message.has_cooldown_ns()) hello.rules.cooldown_ns = message.cooldown_ns();
  if (message.has_settling_ns()) hello.rules.settling_ns = message.settling_ns();
  hello.initial_arm = message.initial_arm();
  for (const v1::Arm& arm : message.arms())
    hello.arms.push_back({.name = arm.name(), .backend_version = arm.backend_version()});
  for (const int capability : message.capabilities())
    hello.capabilities.push_back(static_cast<Capability>(capability));
  return hello;
}

ShadowSample PlainOf(const v1::ShadowSample& message) {
  return {.first_frame_index = message.first_frame_index(),
          .detection_time_ns = message.detection_time_ns(),
          .build_time_ns = message.build_time_ns(),
          .aabb_check_count = message.aabb_check_count(),
          .native_bytes = message.native_bytes(),
          .arm = message.arm(),
          .object_count = message.object_count(),
          .frame_count = message.frame_count(),
          .flags = message.flags()};
}

// REQUIRES: the columns have the same length.
FrameBatch PlainOf(const v1::FrameBatch& message) {
  FrameBatch batch;
  for (int i = 0; i < message.frame_time_ns_size(); ++i) {
    batch.frames.push_back({.frame_index = message.first_frame_index() + static_cast<uint64_t>(i),
                            .frame_time_ns = message.frame_time_ns(i),
                            .detection_time_ns = message.detection_time_ns(i),
                            .aabb_check_count = message.aabb_check_count(i),
                            .native_bytes = message.native_bytes(i),
                            .pair_count = 77,
                            .object_count = message.object_count(i),
                            .arm = message.arm(i),
                            .switch_epoch = message.switch_epoch(i),
                            .flags = message.flags(i),
                            .invalid_box_count = 0});
  }
  if (message.has_scene_descriptor())
    batch.scene_descriptor = FromProto(message.scene_descriptor());
  batch.dropped_frame_count = message.dropped_frame_count();
  for (const v1::ShadowSample& sample : message.shadow_samples())
    batch.shadow_samples.push_back(PlainOf(sample));
  batch.invalid_box_count = message.invalid_box_count();
  return batch;
}

SwitchOutcome PlainOf(const v1::SwitchOutcome& message) {
  return {.command_id = message.command_id(),
          .arm = message.arm(),
          .switch_epoch = message.switch_epoch(),
          .rebuild_time_ns = message.rebuild_time_ns(),
          .settling_cost_ns = message.settling_cost_ns(),
          .reason = static_cast<SwitchReason>(message.reason()),
          .executed = message.executed() ? 1U : 0U,
          .trial_detection_time_ns = message.trial_detection_time_ns(),
          .trial_arm = message.trial_arm()};
}

BailOut PlainOf(const v1::BailOut& message) {
  return {{.frame_index = message.frame_index(),
           .frame_time_ns = message.frame_time_ns(),
           .detection_time_ns = message.detection_time_ns(),
           .aabb_check_count = 77,
           .native_bytes = 77,
           .pair_count = 77,
           .object_count = 77,
           .arm = message.arm(),
           .switch_epoch = message.switch_epoch(),
           .flags = message.flags(),
           .invalid_box_count = 0}};
}

ModeChange PlainOf(const v1::ModeChange& message) {
  return {.mode = static_cast<Mode>(message.mode()),
          .active_arm = message.active_arm(),
          .order_id = message.order_id()};
}

OrderRefusal PlainOf(const v1::OrderRefusal& message) {
  return {.order_id = message.order_id(),
          .reason = static_cast<OrderRefusalReason>(message.reason())};
}

BoxView PlainOf(const v1::BoxView& message) {
  return {.frame_index = message.frame_index(),
          .object_count = message.object_count(),
          .stride = message.stride(),
          .bounds = {message.bounds().begin(), message.bounds().end()},
          .boxes = message.boxes(),
          .pairs = message.pairs()};
}

std::string EncodeAs(const v1::StreamTelemetryRequest& message) {
  switch (message.message_case()) {
    case v1::StreamTelemetryRequest::kHello:
      return Encode(PlainOf(message.hello()));
    case v1::StreamTelemetryRequest::kFrameBatch:
      return Encode(PlainOf(message.frame_batch()));
    case v1::StreamTelemetryRequest::kSwitchOutcome:
      return Encode(PlainOf(message.switch_outcome()));
    case v1::StreamTelemetryRequest::kBailOut:
      return Encode(PlainOf(message.bail_out()));
    case v1::StreamTelemetryRequest::kModeChange:
      return Encode(PlainOf(message.mode_change()));
    case v1::StreamTelemetryRequest::kGoodbye:
      return Encode(Goodbye{});
    case v1::StreamTelemetryRequest::kOrderRefusal:
      return Encode(PlainOf(message.order_refusal()));
    case v1::StreamTelemetryRequest::kBoxView:
      return Encode(PlainOf(message.box_view()));
    case v1::StreamTelemetryRequest::MESSAGE_NOT_SET:
      break;
  }
  return "";
}

// Calls `check` with random requests of each kind. All columns of a batch are filled, because they
// must have the same length.
template <typename Check>
void ForRandomRequests(double share, const Check& check) {
  const auto& kinds = *v1::StreamTelemetryRequest::descriptor()->oneof_decl(0);
  for (int kind = 0; kind < kinds.field_count(); ++kind) {
    if (share < 1 && kinds.field(kind)->name() == "frame_batch") continue;
    for (uint64_t seed = 0; seed < 200; ++seed) {
      SCOPED_TRACE(kinds.field(kind)->name() + ", seed " + std::to_string(seed));
      v1::StreamTelemetryRequest message;
      test_support::RandomMessages(seed, share, static_cast<int>(seed % 5) * 60)
          .Fill(message, kinds.field(kind));
      // A batch without frames has no first frame.
      if (message.has_frame_batch() && message.frame_batch().frame_time_ns().empty())
        message.mutable_frame_batch()->clear_first_frame_index();
      check(message);
    }
  }
}

void ExpectBytesOfProtobuf(const v1::StreamTelemetryRequest& message) {
  const std::string encoded = EncodeAs(message);
  EXPECT_EQ(message.sequence() == 0 ? encoded : Numbered(message.sequence(), encoded),
            message.SerializeAsString());
}

TEST(Encode, EqualsProtobufForEveryFieldOfEveryRequest) {
  ForRandomRequests(1, ExpectBytesOfProtobuf);
}

TEST(Encode, OmitsFieldsWithDefaultValues) { ForRandomRequests(0.5, ExpectBytesOfProtobuf); }

TEST(Encode, OmitsUnmeasuredPropertiesOfTheScene) {
  v1::StreamTelemetryRequest message;
  v1::SceneDescriptor& descriptor = *message.mutable_frame_batch()->mutable_scene_descriptor();
  descriptor.set_object_count(0);
  descriptor.set_static_ratio(0.5F);
  EXPECT_EQ(EncodeAs(message), message.SerializeAsString());
  message.mutable_frame_batch()->clear_scene_descriptor();
  message.mutable_frame_batch()->set_dropped_frame_count(1);
  message.mutable_frame_batch()->add_shadow_samples();
  EXPECT_EQ(EncodeAs(message), message.SerializeAsString());
}

TEST(Encode, AnEncodedMessageCanBeNumberedRepeatedly) {
  const std::string encoded = Encode(ModeChange{.mode = Mode::kManual});
  for (const uint64_t sequence : {uint64_t{1}, uint64_t{128}, ~uint64_t{0}}) {
    v1::StreamTelemetryRequest message;
    ASSERT_TRUE(message.ParseFromString(Numbered(sequence, encoded)));
    EXPECT_EQ(message.sequence(), sequence);
    EXPECT_EQ(message.mode_change().mode(), v1::MODE_MANUAL);
  }
}

}  // namespace
}  // namespace sweepstake::protocol
