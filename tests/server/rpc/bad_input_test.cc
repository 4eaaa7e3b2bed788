// Tests input that breaks the contract: it ends the stream with the right code, is counted, and is
// not evidence.
#include "tests/server/rpc/rpc_test_fixture.h"

#include <grpcpp/impl/codegen/client_context.h>
#include <grpcpp/impl/codegen/sync_stream.h>
#include <spdlog/sinks/ringbuffer_sink.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

constexpr char kStreamTelemetry[] = "/sweepstake.v1.TelemetryService/StreamTelemetry";

// Sends raw bytes that no generated stub would send.
class RawClient {
 public:
  explicit RawClient(const std::shared_ptr<grpc::Channel>& channel,
                     const char* method = kStreamTelemetry,
                     grpc_compression_algorithm compression = GRPC_COMPRESS_NONE)
      : method_(method, grpc::internal::RpcMethod::BIDI_STREAMING, channel) {
    context_.set_compression_algorithm(compression);
    stream_ = std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>>(
        grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
            channel.get(), method_, &context_));
  }
  void Send(const std::string& bytes) {
    const grpc::Slice slice(bytes);
    stream_->Write(grpc::ByteBuffer(&slice, 1));
  }
  grpc::Status Finish() {
    grpc::ByteBuffer ignored;
    while (stream_->Read(&ignored)) {
    }
    return stream_->Finish();
  }

 private:
  grpc::ClientContext context_;
  grpc::internal::RpcMethod method_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
};

class BadInputTest : public RpcTest {
 protected:
  // Returns how a stream ends that sends `request` after a valid Hello.
  grpc::Status EndAfter(const v1::StreamTelemetryRequest& request) {
    TelemetryClient client(channel_);
    client.Open(HelloMessage());
    client.Send(request);
    return client.Finish();
  }
};

TEST_F(BadInputTest, ShadowSamplesNeedAnArmAndATimeAndAreLimitedPerBatch) {
  const auto with_samples = [](int count) {
    v1::StreamTelemetryRequest request = Frames(1, 1);
    for (int i = 0; i < count; ++i) {
      request.mutable_frame_batch()->add_shadow_samples()->set_detection_time_ns(1);
    }
    return request;
  };
  EXPECT_TRUE(CheckRequest(with_samples(64), 3).ok());
  EXPECT_EQ(ReasonOf(EndAfter(with_samples(65))), v1::ERROR_REASON_INVALID_MESSAGE);
  v1::StreamTelemetryRequest request = with_samples(2);
  request.mutable_frame_batch()->mutable_shadow_samples(1)->set_arm(3);
  EXPECT_EQ(EndAfter(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request = with_samples(2);
  request.mutable_frame_batch()->mutable_shadow_samples(1)->clear_detection_time_ns();
  EXPECT_EQ(EndAfter(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

sessions::Telemetry Converted(const v1::StreamTelemetryRequest& request) {
  sessions::Telemetry telemetry;
  FromProto(request, telemetry);
  return telemetry;
}

TEST_F(BadInputTest, ABatchCannotBeginWithAnAbsurdFrame) {
  v1::StreamTelemetryRequest request = Frames(1, 1);
  request.mutable_frame_batch()->set_first_frame_index(uint64_t{1} << 63);
  EXPECT_TRUE(CheckRequest(request, 3).ok());
  request.mutable_frame_batch()->set_first_frame_index((uint64_t{1} << 63) + 1);
  EXPECT_EQ(ReasonOf(EndAfter(request)), v1::ERROR_REASON_INVALID_MESSAGE);
}

TEST(MessageValidation, NumbersTheFramesOfABatchFromTheFirst) {
  v1::StreamTelemetryRequest request = Frames(1, 3);
  request.mutable_frame_batch()->set_first_frame_index(70);
  const sessions::Telemetry telemetry = Converted(request);
  const auto& frames = std::get<protocol::FrameBatch>(telemetry.message).frames;
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].frame_index, 70U);
  EXPECT_EQ(frames[2].frame_index, 72U);
}

TEST(MessageValidation, AcceptsOnlyMeasuredValuesOfTheScene) {
  v1::StreamTelemetryRequest request;
  v1::SceneDescriptor& message = *request.mutable_frame_batch()->mutable_scene_descriptor();
  message.set_object_count(1000);
  message.set_density_ratio(std::numeric_limits<float>::quiet_NaN());
  message.set_size_spread(std::numeric_limits<float>::infinity());
  message.set_speed_mean(-1);
  message.set_static_ratio(0);
  const SceneDescriptor descriptor =
      *std::get<protocol::FrameBatch>(Converted(request).message).scene_descriptor;
  EXPECT_EQ(descriptor.object_count, 1000);
  EXPECT_FALSE(decision::IsMeasured(descriptor.density_ratio));
  EXPECT_FALSE(decision::IsMeasured(descriptor.size_spread));
  EXPECT_FALSE(decision::IsMeasured(descriptor.speed_mean));
  EXPECT_FALSE(decision::IsMeasured(descriptor.speed_spread));
  EXPECT_EQ(descriptor.static_ratio, 0);
}

TEST(MessageValidation, LimitsTheCostOfASwitch) {
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
  const auto cost = [&request] {
    return std::get<sessions::SwitchAnswer>(Converted(request).message).cost;
  };
  outcome.set_rebuild_time_ns(12);
  outcome.set_settling_cost_ns(~0ull);
  EXPECT_EQ(cost().rebuild_time_ns, 12u);
  EXPECT_EQ(cost().settling_cost_ns, 3600u * uint64_t{kSecondNs});
  EXPECT_FALSE(cost().ended_trial);
  outcome.set_trial_arm(2);
  outcome.set_trial_detection_time_ns(~0ull);
  ASSERT_TRUE(cost().ended_trial);
  EXPECT_EQ(cost().ended_trial->arm, 2u);
  EXPECT_EQ(cost().ended_trial->detection_time_ns, 3600u * uint64_t{kSecondNs});
}

TEST(MessageValidation, ATrialMustNameAnArmOfTheSession) {
  v1::StreamTelemetryRequest request;
  request.set_sequence(1);
  v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
  outcome.set_reason(v1::SWITCH_REASON_POLICY);
  outcome.set_trial_arm(2);
  EXPECT_TRUE(CheckRequest(request, 3).ok());
  outcome.set_trial_arm(3);
  EXPECT_FALSE(CheckRequest(request, 3).ok());
}

TEST(MessageValidation, KeepsTheFieldsOfAShadowSampleApart) {
  v1::StreamTelemetryRequest request;
  v1::ShadowSample& message = *request.mutable_frame_batch()->add_shadow_samples();
  message.set_first_frame_index(1);
  message.set_arm(2);
  message.set_detection_time_ns(3);
  message.set_build_time_ns(4);
  message.set_aabb_check_count(5);
  message.set_native_bytes(6);
  message.set_object_count(7);
  message.set_frame_count(8);
  message.set_flags(0xFF);
  const ShadowSample sample =
      std::get<protocol::FrameBatch>(Converted(request).message).shadow_samples.at(0);
  EXPECT_EQ(sample.first_frame_index, 1u);
  EXPECT_EQ(sample.arm, 2u);
  EXPECT_EQ(sample.detection_time_ns, 3u);
  EXPECT_EQ(sample.build_time_ns, 4u);
  EXPECT_EQ(sample.aabb_check_count, 5u);
  EXPECT_EQ(sample.native_bytes, 6u);
  EXPECT_EQ(sample.object_count, 7u);
  EXPECT_EQ(sample.frame_count, 8u);
  EXPECT_EQ(sample.flags, kShadowActive | kShadowCapped);
}

TEST_F(BadInputTest, BytesThatDoNotParseAreInvalidAndChangeNothing) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
  }
  const priors::SceneEvidence before = Stored();
  RawClient raw(channel_);
  raw.Send(Request(hello).SerializeAsString());
  raw.Send("\xff\xff\xff not a message");
  const grpc::Status status = raw.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_MALFORMED_MESSAGE);
  EXPECT_THAT(status.error_message(), HasSubstr("does not parse"));
  EXPECT_EQ(server_->counters().malformed_message_count, 1u);
  EXPECT_EQ(Stored().arms[0].live, before.arms[0].live);
}

TEST_F(BadInputTest, OneOfTwoConcurrentResumptionsWithDifferentArmsConnectsAgainForANewSession) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
  }
  RestartServer();
  std::promise<void> release;
  thread_.Submit([&](priors::PriorStore&) { release.get_future().wait(); });
  const size_t jobs = store_.submit_count();
  TelemetryClient first(channel_);
  first.Send(Request(hello));
  ASSERT_TRUE(Eventually([&] { return store_.submit_count() == jobs + 1; }));
  v1::Hello other = hello;
  other.add_arms()->set_name("DBVT");
  other.mutable_arms(3)->set_backend_version(1);
  other.set_active_arm(3);
  other.set_mode(v1::MODE_MANUAL);
  TelemetryClient second(channel_);
  second.Send(Request(other));
  ASSERT_TRUE(Eventually([&] { return store_.submit_count() == jobs + 2; }));
  release.set_value();
  EXPECT_TRUE(first.Await(&v1::StreamTelemetryResponse::has_welcome).welcome().resumed());
  EXPECT_EQ(ReasonOf(second.Finish()), v1::ERROR_REASON_STORE_BUSY);
  const v1::Welcome welcome = TelemetryClient(channel_).Open(other);
  EXPECT_FALSE(welcome.resumed());
  EXPECT_NE(welcome.session_id(), hello.session_id());
  first.Send(Frames(2, 30));
  EXPECT_TRUE(Applied(1)) << "the first one continues";
}

TEST_F(BadInputTest, ATruncatedMessageIsInvalid) {
  const std::string whole = Request(HelloMessage()).SerializeAsString();
  RawClient raw(channel_);
  raw.Send(whole.substr(0, whole.size() - 3));
  EXPECT_EQ(ReasonOf(raw.Finish()), v1::ERROR_REASON_MALFORMED_MESSAGE);
}

TEST_F(BadInputTest, AWatchersUnparsableBytesAreLogged) {
  const auto lines = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(10);
  log_.sinks().push_back(lines);
  RawClient raw(channel_, "/sweepstake.v1.PosteriorsService/WatchPosteriors");
  raw.Send("\xff\xff\xff not a message");
  EXPECT_EQ(ReasonOf(raw.Finish()), v1::ERROR_REASON_MALFORMED_MESSAGE);
  EXPECT_THAT(lines->last_formatted(), ::testing::ElementsAre(HasSubstr("(MALFORMED_MESSAGE)")));
}

TEST_F(BadInputTest, AMessageOverTheLimitExhaustsResources) {
  RawClient raw(channel_);
  raw.Send(std::string(256 * 1024 + 1, 'x'));
  const grpc::Status status = raw.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_MESSAGE_TOO_LONG);
  EXPECT_THAT(status.error_message(), HasSubstr("262144 bytes"));
}

TEST_F(BadInputTest, ACompressedMessageIsNotImplemented) {
  RawClient raw(channel_, kStreamTelemetry, GRPC_COMPRESS_GZIP);
  raw.Send(std::string(10'000, 'x'));
  const grpc::Status status = raw.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_MESSAGE_COMPRESSED);
  EXPECT_THAT(status.error_message(), HasSubstr("compressed"));
}

TEST_F(BadInputTest, TheFirstRequestMustBeHello) {
  TelemetryClient client(channel_);
  client.Send(Frames(1, 30));
  const grpc::Status status = client.Finish();
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_MESSAGE_ORDER);
  EXPECT_THAT(status.error_message(), HasSubstr("Hello"));
}

TEST_F(BadInputTest, ASecondHelloIsOutOfOrder) {
  EXPECT_EQ(ReasonOf(EndAfter(Request(HelloMessage()))), v1::ERROR_REASON_MESSAGE_ORDER);
}

TEST_F(BadInputTest, AnOverlongBatchIsInvalid) {
  EXPECT_EQ(EndAfter(Frames(1, 241)).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(server_->counters().invalid_message_count, 1u);
  EXPECT_EQ(server_->counters().applied_message_count, 0u);
}

struct BadHello {
  const char* what;
  std::function<void(v1::Hello&)> spoil;
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
};

class BadHelloTest : public ::testing::TestWithParam<BadHello> {};

TEST_P(BadHelloTest, IsRefused) {
  v1::Hello hello = HelloMessage();
  ASSERT_TRUE(CheckHello(hello, {}).ok());
  GetParam().spoil(hello);
  EXPECT_EQ(CheckHello(hello, {}).code(), GetParam().code) << CheckHello(hello, {});
}

INSTANTIATE_TEST_SUITE_P(
    Hellos, BadHelloTest,
    ::testing::Values(
        BadHello{"NoVersion", [](auto& h) { h.clear_protocol_version(); },
                 absl::StatusCode::kFailedPrecondition},
        BadHello{"AnotherVersion", [](auto& h) { h.set_protocol_version(protocol::kVersion + 1); },
                 absl::StatusCode::kFailedPrecondition},
        BadHello{"NoProject", [](auto& h) { h.clear_project(); }},
        BadHello{"NoScene", [](auto& h) { h.clear_scene(); }},
        BadHello{"LongProject", [](auto& h) { h.set_project(std::string(129, 'x')); }},
        BadHello{"ControlCharacter", [](auto& h) { h.set_scene("a\nb"); }},
        BadHello{"Nul", [](auto& h) { h.set_scene(std::string("a\0b", 3)); }},
        BadHello{"Delete", [](auto& h) { h.set_scene("a\x7f"); }},
        BadHello{"LateControlCharacter", [](auto& h) { h.set_scene("a\xc2\x85"); }},
        BadHello{"LongMachineClass", [](auto& h) { h.set_machine_class(std::string(129, 'x')); }},
        BadHello{"NoArms", [](auto& h) { h.clear_arms(); }},
        BadHello{"TooManyArms",
                 [](auto& h) {
                   for (int i = 0; i < 30; ++i) {
                     h.add_arms()->set_name("arm " + std::to_string(i));
                     h.mutable_arms()->rbegin()->set_backend_version(1);
                   }
                 }},
        BadHello{"ArmTwice", [](auto& h) { h.mutable_arms(0)->set_name("SAP"); }},
        BadHello{"NamelessArm", [](auto& h) { h.mutable_arms(0)->clear_name(); }},
        BadHello{"NoBackendVersion", [](auto& h) { h.mutable_arms(0)->clear_backend_version(); }},
        BadHello{"ActiveArmOutOfRange", [](auto& h) { h.set_active_arm(3); }},
        BadHello{"InitialArmOutOfRange", [](auto& h) { h.set_initial_arm(3); }},
        BadHello{"NoMode", [](auto& h) { h.clear_mode(); }},
        BadHello{"UnknownMode", [](auto& h) { h.set_mode(static_cast<v1::Mode>(9)); }},
        BadHello{"UnknownPolicy", [](auto& h) { h.set_policy("dice"); }},
        BadHello{"ScaleNaN", [](auto& h) { h.set_time_scale(std::nan("")); }},
        BadHello{"ScaleInfinite",
                 [](auto& h) { h.set_time_scale(std::numeric_limits<double>::infinity()); }},
        BadHello{"ScaleTooSmall", [](auto& h) { h.set_time_scale(0.5); }},
        BadHello{"ScaleNegative", [](auto& h) { h.set_time_scale(-1); }},
        BadHello{"ScaleTooLarge", [](auto& h) { h.set_time_scale(1001); }}),
    [](const auto& instance) { return std::string(instance.param.what); });

TEST(MessageValidationTest, ATooLargeTimeScaleIsRefusedWithAdvice) {
  v1::Hello hello = HelloMessage();
  RpcOptions options;
  hello.set_time_scale(7.5);
  EXPECT_EQ(CheckHello(hello, options),
            Refused(v1::ERROR_REASON_TIME_SCALE,
                    "this daemon allows a time scale up to 1, not 7.5; use "
                    "a smaller one, or start the daemon with --max-time-scale 8"));
  options.max_time_scale = 7;
  EXPECT_TRUE(absl::IsInvalidArgument(CheckHello(hello, options)));
  options.max_time_scale = 8;
  EXPECT_TRUE(CheckHello(hello, options).ok());
}

TEST(MessageValidationTest, ARefusalOfAnotherProtocolVersionNamesBothVersions) {
  v1::Hello hello = HelloMessage();
  hello.set_protocol_version(99);
  EXPECT_EQ(CheckHello(hello, {}),
            Refused(v1::ERROR_REASON_PROTOCOL_VERSION,
                    "this daemon has version 1 of the protocol, the client has version 99; update "
                    "the older side"));
}

TEST(MessageValidationTest, AnUnknownPolicyIsAnsweredWithTheKnownOnes) {
  v1::Hello hello = HelloMessage();
  hello.set_policy("dice");
  EXPECT_THAT(std::string(CheckHello(hello, {}).message()), HasSubstr("paper"));
}

TEST(MessageValidationTest, AnAblationOfTheLaboratoryIsAnUnknownPolicy) {
  v1::Hello hello = HelloMessage();
  hello.set_policy("adaptive-without-shadow");
  const std::string message(CheckHello(hello, {}).message());
  EXPECT_THAT(message, HasSubstr("unknown policy"));
  EXPECT_THAT(message, HasSubstr("paper"));
  EXPECT_THAT(message, testing::Not(testing::HasSubstr("adaptive-without-gate")));
}

TEST(MessageValidationTest, ARequestThatBreaksTheContractIsInvalid) {
  using Spoil = std::function<void(v1::StreamTelemetryRequest&)>;
  const std::vector<std::pair<const char*, Spoil>> cases = {
      {"no message", [](auto& r) { r.clear_message(); }},
      {"no sequence", [](auto& r) { r.clear_sequence(); }},
      {"sequence of 64 bits", [](auto& r) { r.set_sequence(1ull << 63); }},
      {"no frames", [](auto& r) { r.mutable_frame_batch()->Clear(); }},
      {"a short column", [](auto& r) { r.mutable_frame_batch()->mutable_flags()->RemoveLast(); }},
      {"a long column", [](auto& r) { r.mutable_frame_batch()->add_native_bytes(1); }},
      {"more dropped frames than there can be",
       [](auto& r) { r.mutable_frame_batch()->set_dropped_frame_count(~0ull); }},
      {"an unknown arm", [](auto& r) { r.mutable_frame_batch()->set_arm(0, 3); }},
      {"a bail-out of an unknown arm", [](auto& r) { r.mutable_bail_out()->set_arm(3); }},
      {"a mode that is absent", [](auto& r) { r.mutable_mode_change(); }},
      {"an active arm that is unknown",
       [](auto& r) {
         r.mutable_mode_change()->set_mode(v1::MODE_AI);
         r.mutable_mode_change()->set_active_arm(3);
       }},
      {"a switch without a reason", [](auto& r) { r.mutable_switch_outcome(); }},
      {"a switch to an unknown arm",
       [](auto& r) {
         r.mutable_switch_outcome()->set_reason(v1::SWITCH_REASON_POLICY);
         r.mutable_switch_outcome()->set_arm(3);
       }},
  };
  for (const auto& [what, spoil] : cases) {
    v1::StreamTelemetryRequest request = Frames(1, 3);
    ASSERT_TRUE(CheckRequest(request, 3).ok());
    spoil(request);
    EXPECT_TRUE(absl::IsInvalidArgument(CheckRequest(request, 3))) << what;
  }
}

}  // namespace
}  // namespace sweepstake::rpc
