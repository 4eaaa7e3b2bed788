// Compares the client's decoder with protobuf: each field of each message, and bytes that are
// invalid.
#include <google/protobuf/unknown_field_set.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "engine_client/telemetry/protocol/wire.h"
#include "sweepstake/v1/errors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"
#include "tests/engine_client/telemetry/protocol/random_messages.h"

namespace sweepstake::protocol {
namespace {

template <typename To>
void Write(const std::vector<decision::BetaPosterior>& posteriors, To& to) {
  for (const decision::BetaPosterior& posterior : posteriors) {
    v1::BetaPosterior& message = *to.Add();
    message.set_alpha(posterior.alpha);
    message.set_beta(posterior.beta);
  }
}

void Write(const Welcome& welcome, v1::Welcome& message) {
  message.set_session_id(welcome.session_id);
  message.set_resumed(welcome.resumed);
  message.set_acknowledged_sequence(welcome.acknowledged_sequence);
  message.set_max_batch_frames(welcome.max_batch_frames);
  message.set_max_message_bytes(welcome.max_message_bytes);
  message.set_batch_interval_ms(welcome.batch_interval_ms);
  message.set_decision_interval_ms(welcome.decision_interval_ms);
  message.set_settling_ms(welcome.settling_ms);
  message.set_bail_out_ms(welcome.bail_out_ms);
  message.set_daemon_version(welcome.daemon_version);
  message.set_policy(welcome.policy);
  message.set_seed(welcome.seed);
  Write(welcome.priors, *message.mutable_priors());
  message.set_prior_source_count(welcome.prior_source_count);
  message.set_resume_token(welcome.resume_token);
  message.set_priors_unavailable(welcome.priors_unavailable);
  for (const Capability each : welcome.capabilities)
    message.add_capabilities(static_cast<v1::Capability>(each));
  message.set_cooldown_ms(welcome.cooldown_ms);
  if (!welcome.weights) return;
  message.mutable_weights()->set_fps(welcome.weights->fps);
  message.mutable_weights()->set_detection(welcome.weights->detection);
  message.mutable_weights()->set_memory(welcome.weights->memory);
  message.mutable_weights()->set_checks(welcome.weights->checks);
}

void Write(const SwitchCommand& command, v1::SwitchCommand& message) {
  message.set_command_id(command.command_id);
  message.set_arm(command.arm);
  message.set_reason(static_cast<v1::SwitchReason>(command.reason));
  message.set_trial_limit_percent(command.trial_limit_percent);
}

void Write(const ArmStanding& standing, v1::ArmStanding& message) {
  message.set_live_window_count(standing.live_window_count);
  message.set_lane_visit_count(standing.lane_visit_count);
  message.set_effective_window_count(standing.effective_window_count);
  message.set_best_probability(standing.best_probability);
  if (!standing.cost_ratio) return;
  message.mutable_cost_ratio()->set_median(standing.cost_ratio->median);
  message.mutable_cost_ratio()->set_low(standing.cost_ratio->low);
  message.mutable_cost_ratio()->set_high(standing.cost_ratio->high);
}

void Write(const PosteriorSnapshot& snapshot, v1::PosteriorSnapshot& message) {
  Write(snapshot.arms, *message.mutable_arms());
  message.set_verdict(static_cast<v1::Verdict>(snapshot.verdict.verdict));
  message.set_leader_arm(snapshot.verdict.leader_arm);
  message.set_leader_probability(snapshot.verdict.leader_probability);
  for (const ArmStanding& standing : snapshot.standings) Write(standing, *message.add_standings());
  if (snapshot.saved_us) message.set_saved_us(*snapshot.saved_us);
}

void Write(const OperatorOrder& order, v1::OperatorOrder& message) {
  message.set_order_id(order.order_id);
  message.set_mode(static_cast<v1::Mode>(order.mode));
  if (order.arm) message.set_arm(*order.arm);
}

void Write(const BoxRequest& request, v1::BoxRequest& message) {
  message.set_interval_ms(request.interval_ms);
  message.set_max_bytes(request.max_bytes);
  message.set_until_ms(request.until_ms);
}

v1::StreamTelemetryResponse MessageOf(const Response& response) {
  v1::StreamTelemetryResponse message;
  if (response.welcome) Write(*response.welcome, *message.mutable_welcome());
  if (response.switch_command) Write(*response.switch_command, *message.mutable_switch_command());
  if (response.acknowledgement) {
    message.mutable_acknowledgement()->set_sequence(response.acknowledgement->sequence);
    message.mutable_acknowledgement()->set_batch_interval_ms(
        response.acknowledgement->batch_interval_ms);
  }
  if (response.posterior_snapshot)
    Write(*response.posterior_snapshot, *message.mutable_posterior_snapshot());
  if (response.reconnect) message.mutable_reconnect()->set_delay_ms(response.reconnect->delay_ms);
  if (response.operator_order) Write(*response.operator_order, *message.mutable_operator_order());
  if (response.box_request) Write(*response.box_request, *message.mutable_box_request());
  return message;
}

v1::StreamTelemetryResponse RandomResponse(uint64_t seed, double share) {
  v1::StreamTelemetryResponse message;
  test_support::RandomMessages(seed, share, static_cast<int>(seed % 4)).Fill(message);
  return message;
}

std::string Text(const v1::StreamTelemetryResponse& message) { return message.DebugString(); }

TEST(Decode, ReadsEveryFieldOfEveryResponse) {
  for (const double share : {1.0, 0.5}) {
    for (uint64_t seed = 0; seed < 500; ++seed) {
      SCOPED_TRACE(seed);
      const v1::StreamTelemetryResponse message = RandomResponse(seed, share);
      const auto response = DecodeResponse(message.SerializeAsString());
      ASSERT_TRUE(response);
      EXPECT_EQ(Text(MessageOf(*response)), Text(message));
      EXPECT_FALSE(response->has_unknown);
    }
  }
}

TEST(Decode, MergesAMessageThatOccursInTwoParts) {
  v1::StreamTelemetryResponse first;
  first.mutable_welcome()->set_session_id("a");
  first.mutable_welcome()->add_priors()->set_alpha(1);
  v1::StreamTelemetryResponse second;
  second.mutable_welcome()->set_seed(7);
  second.mutable_welcome()->add_priors()->set_alpha(2);
  const auto response = DecodeResponse(first.SerializeAsString() + second.SerializeAsString());
  ASSERT_TRUE(response);
  first.MergeFrom(second);
  EXPECT_EQ(Text(MessageOf(*response)), Text(first));
}

TEST(Decode, SkipsFieldsOfANewerProtocolAndReportsThem) {
  v1::StreamTelemetryResponse message = RandomResponse(1, 1);
  message.mutable_welcome()
      ->GetReflection()
      ->MutableUnknownFields(message.mutable_welcome())
      ->AddLengthDelimited(99, "new");
  auto response = DecodeResponse(message.SerializeAsString());
  ASSERT_TRUE(response);
  EXPECT_FALSE(response->has_unknown) << "the unknown field is inside a known message";
  message.GetReflection()->MutableUnknownFields(&message)->AddVarint(50, 1);
  response = DecodeResponse(message.SerializeAsString());
  ASSERT_TRUE(response);
  EXPECT_TRUE(response->has_unknown);
  EXPECT_EQ(response->welcome->session_id, message.welcome().session_id());
}

TEST(Decode, RefusesATruncatedMessageIfProtobufDoes) {
  const std::string bytes = RandomResponse(2, 1).SerializeAsString();
  size_t refused_count = 0;
  for (size_t size = 0; size < bytes.size(); ++size) {
    v1::StreamTelemetryResponse message;
    const bool valid = message.ParseFromString(bytes.substr(0, size));
    EXPECT_EQ(DecodeResponse(bytes.substr(0, size)).has_value(), valid) << size;
    if (!valid) ++refused_count;
  }
  EXPECT_GT(refused_count, bytes.size() / 2);
}

// Protobuf also refuses field numbers of more than 32 bits; our decoder uses their lowest bits.
TEST(Decode, ReadsCorruptBytesAsProtobufDoes) {
  size_t read_count = 0;
  size_t refused_count = 0;
  math::SplitMix64 random{3};
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes =
        RandomResponse(1 + static_cast<uint64_t>(round % 50), 0.9).SerializeAsString();
    for (int i = 0; i < 3; ++i)
      bytes[random.Next() % bytes.size()] = static_cast<char>(random.Next());
    const auto response = DecodeResponse(bytes);
    if (!response) continue;
    ++read_count;
    v1::StreamTelemetryResponse message;
    if (!message.ParseFromString(bytes)) {
      ++refused_count;
      continue;
    }
    message.DiscardUnknownFields();
    EXPECT_EQ(Text(MessageOf(*response)), Text(message)) << round;
  }
  EXPECT_GT(read_count, 1000U);
  EXPECT_LT(refused_count, read_count / 100);
}

TEST(Decode, RefusesTextsWithLineBreaksOrInvalidUtf8) {
  for (const char* text : {"\xff", "two\nlines"}) {
    v1::StreamTelemetryResponse message;
    message.mutable_welcome()->set_daemon_version("1");
    std::string bytes = message.SerializeAsString();
    bytes.replace(bytes.size() - 1, 1, text);
    bytes[1] = static_cast<char>(bytes.size() - 2);
    bytes[3] = static_cast<char>(bytes.size() - 4);
    EXPECT_FALSE(DecodeResponse(bytes)) << text;
  }
}

v1::StatusDetails DetailsWith(const std::string& reason, const std::string& domain) {
  v1::ErrorInfo info;
  info.set_reason(reason);
  info.set_domain(domain);
  v1::StatusDetails details;
  details.set_code(9);
  details.set_message("ends");
  google::protobuf::Any& other = *details.add_details();
  other.set_type_url("type.googleapis.com/google.rpc.RetryInfo");
  other.set_value("\xff\xff");
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  detail.set_value(info.SerializeAsString());
  return details;
}

TEST(StatusIn, FindsTheReasonAmongTheDetails) {
  const auto status = StatusIn(DetailsWith("DRAINING", "sweepstake").SerializeAsString());
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(status->code, 9u);
  EXPECT_EQ(status->message, "ends");
  EXPECT_EQ(status->reason, "DRAINING");
}

TEST(StatusIn, IsNothingWithoutAReasonOfTheDaemon) {
  EXPECT_FALSE(StatusIn(""));
  EXPECT_FALSE(StatusIn("\xff\xff\xff"));
  EXPECT_FALSE(StatusIn(DetailsWith("DRAINING", "proxy.example").SerializeAsString()));
  EXPECT_FALSE(StatusIn(DetailsWith("A\nB", "sweepstake").SerializeAsString()));
  for (const int32_t code : {0, -1, 17}) {
    v1::StatusDetails details = DetailsWith("DRAINING", "sweepstake");
    details.set_code(code);
    EXPECT_FALSE(StatusIn(details.SerializeAsString())) << code;
  }
}

}  // namespace
}  // namespace sweepstake::protocol
