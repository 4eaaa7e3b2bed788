// Tests the complete protocol of a session, message by message and in scripted time. The daemon's
// side uses protobuf.
#include "engine_client/telemetry/protocol/session_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sweepstake/v1/errors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMs = 1'000'000;
constexpr uint32_t kUnavailable = 14;
constexpr uint32_t kPermissionDenied = 7;

v1::StreamTelemetryResponse WelcomeTo(const std::string& session, bool resumed = false,
                                      uint64_t acknowledged = 0) {
  v1::StreamTelemetryResponse response;
  v1::Welcome& welcome = *response.mutable_welcome();
  welcome.set_session_id(session);
  welcome.set_resume_token("token of " + session);
  welcome.set_resumed(resumed);
  welcome.set_acknowledged_sequence(acknowledged);
  welcome.set_daemon_version("0.1.0");
  welcome.set_policy("paper");
  welcome.set_seed(7);
  return response;
}

StreamEnd EndWith(uint32_t code, const std::string& message, const std::string& reason = "") {
  v1::StatusDetails details;
  if (!reason.empty()) {
    details.set_code(static_cast<int32_t>(code));
    details.set_message(message);
    v1::ErrorInfo info;
    info.set_reason(reason);
    info.set_domain("sweepstake");
    google::protobuf::Any& detail = *details.add_details();
    detail.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
    detail.set_value(info.SerializeAsString());
  }
  return {code, message, details.SerializeAsString()};
}

SessionOptions Options() {
  SessionOptions options;
  options.batch_frames = 1;
  options.backoff_min_ms = 100;
  options.backoff_max_ms = 1000;
  return options;
}

class SessionLinkTest : public ::testing::Test {
 protected:
  void Frames(int count) {
    for (int i = 0; i < count; ++i) {
      FrameSample sample{};
      sample.frame_index = next_frame_++;
      sample.frame_time_ns = 1000;
      queue_.OnFrame(sample);
    }
  }

  v1::StreamTelemetryRequest Take() {
    v1::StreamTelemetryRequest request;
    EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kSend);
    EXPECT_TRUE(request.ParseFromString(link_.Take(now_ns_)));
    return request;
  }
  // Returns the sequence numbers of the messages that can be sent now.
  std::vector<uint64_t> TakeAll() {
    std::vector<uint64_t> sequences;
    while (link_.Advance(now_ns_) == LinkAction::kSend) sequences.push_back(Take().sequence());
    return sequences;
  }
  Status Receive(const v1::StreamTelemetryResponse& response) {
    return link_.OnMessage(response.SerializeAsString(), now_ns_);
  }
  // Opens a stream and returns its Hello.
  v1::Hello Connect() {
    link_.Connected(now_ns_);
    return Take().hello();
  }
  void GoOnline() {
    Connect();
    EXPECT_TRUE(Receive(WelcomeTo("a")).ok());
  }

  using Sequences = std::vector<uint64_t>;
  SampleQueue queue_{64};
  std::unique_ptr<AdaptiveBroadPhase> adaptive_ =
      std::move(*AdaptiveBroadPhase::Create({.arms = {"BruteForce", "Grid"}}, &queue_));
  SessionLink link_{Options(), "the daemon", 7, queue_, *adaptive_};
  uint64_t now_ns_ = 1000 * kMs;
  uint64_t next_frame_ = 0;
};

TEST_F(SessionLinkTest, SendsOnlyTheHelloBeforeTheWelcome) {
  Frames(2);
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kNone) << "there is no stream yet";
  const v1::Hello hello = Connect();
  EXPECT_EQ(hello.arms(1).name(), "Grid");
  EXPECT_EQ(hello.session_id(), "");
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kNone);
  EXPECT_EQ(link_.stats().state, ConnectionState::kConnecting);
  ASSERT_TRUE(Receive(WelcomeTo("a")).ok());
  EXPECT_EQ(link_.stats().state, ConnectionState::kOnline);
  EXPECT_EQ(TakeAll(), (Sequences{1, 2}));
}

TEST_F(SessionLinkTest, ReadsTheQueueWhileNothingCanBeSent) {
  GoOnline();
  for (int i = 0; i < 10; ++i) {
    Frames(60);
    EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kSend);
  }
  EXPECT_EQ(queue_.dropped_frame_count(), 0U);
  EXPECT_EQ(TakeAll().size(), 600U);
}

TEST_F(SessionLinkTest, ResumesAfterTheLastAcknowledgedMessage) {
  GoOnline();
  Frames(5);
  EXPECT_EQ(Take().sequence(), 1U);
  EXPECT_EQ(Take().sequence(), 2U);
  EXPECT_EQ(Take().sequence(), 3U);
  EXPECT_TRUE(link_.Disconnected(EndWith(kUnavailable, "gone"), now_ns_));
  const v1::Hello hello = Connect();
  EXPECT_EQ(hello.session_id(), "a");
  EXPECT_EQ(hello.resume_token(), "token of a");
  ASSERT_TRUE(Receive(WelcomeTo("a", true, 1)).ok());
  EXPECT_EQ(TakeAll(), (Sequences{2, 3, 4, 5}));
  EXPECT_EQ(link_.stats().resumed_count, 1U);
  EXPECT_EQ(link_.stats().resent_message_count, 2U);
}

TEST_F(SessionLinkTest, RenumbersMessagesInANewSession) {
  GoOnline();
  Frames(3);
  TakeAll();
  v1::StreamTelemetryResponse acknowledgement;
  acknowledgement.mutable_acknowledgement()->set_sequence(1);
  ASSERT_TRUE(Receive(acknowledgement).ok());
  link_.Disconnected(EndWith(kUnavailable, "gone"), now_ns_);
  EXPECT_EQ(Connect().session_id(), "a");
  link_.Disconnected(EndWith(5, "no such session"), now_ns_);
  EXPECT_EQ(Connect().session_id(), "");
  ASSERT_TRUE(Receive(WelcomeTo("b")).ok());
  EXPECT_EQ(TakeAll(), (Sequences{1, 2}));
}

TEST_F(SessionLinkTest, KeepsTheLatestCommandAndVerdictForTheGame) {
  GoOnline();
  v1::StreamTelemetryResponse snapshot;
  snapshot.mutable_posterior_snapshot()->set_verdict(v1::VERDICT_STABLE);
  snapshot.mutable_posterior_snapshot()->set_leader_arm(1);
  snapshot.mutable_posterior_snapshot()->set_leader_probability(0.875);
  ASSERT_TRUE(Receive(snapshot).ok());
  EXPECT_FALSE(adaptive_->last_decision()) << "only a verdict arrived, no decision";
  v1::StreamTelemetryResponse command;
  command.mutable_switch_command()->set_command_id(4);
  command.mutable_switch_command()->set_arm(1);
  command.mutable_switch_command()->set_reason(v1::SWITCH_REASON_EXPLORATION);
  ASSERT_TRUE(Receive(command).ok());
  std::optional<LastDecision> decision = adaptive_->last_decision();
  ASSERT_TRUE(decision);
  EXPECT_EQ(decision->decision_id, 0U);
  EXPECT_EQ(decision->time_ns, now_ns_);
  EXPECT_EQ(decision->candidate_arm, 1U);
  EXPECT_EQ(decision->command->command_id, 4U);
  EXPECT_EQ(decision->command->reason, SwitchReason::kExploration);
  EXPECT_EQ(decision->verdict.leader_probability, 0.875);
  EXPECT_EQ(decision->arm_count, 0U);
  snapshot.mutable_posterior_snapshot()->set_verdict(v1::VERDICT_TIE);
  now_ns_ += kMs;
  ASSERT_TRUE(Receive(snapshot).ok());
  decision = adaptive_->last_decision();
  EXPECT_EQ(decision->verdict.verdict, Verdict::kTie);
  EXPECT_EQ(decision->time_ns, now_ns_ - kMs);
}

TEST_F(SessionLinkTest, KeepsTheLatestSavingThatIsANumber) {
  GoOnline();
  EXPECT_FALSE(link_.stats().saved_us);
  v1::StreamTelemetryResponse response;
  v1::PosteriorSnapshot& snapshot = *response.mutable_posterior_snapshot();
  for (const double saved_us : {-2.5, std::nan(""), HUGE_VAL}) {
    snapshot.set_saved_us(saved_us);
    ASSERT_TRUE(Receive(response).ok());
    EXPECT_EQ(link_.stats().saved_us, -2.5);
  }
  snapshot.clear_saved_us();
  ASSERT_TRUE(Receive(response).ok());
  EXPECT_FALSE(link_.stats().saved_us);
}

v1::StreamTelemetryResponse SnapshotOf(size_t arm_count) {
  v1::StreamTelemetryResponse response;
  for (size_t arm = 0; arm < arm_count; ++arm) {
    v1::BetaPosterior& posterior = *response.mutable_posterior_snapshot()->add_arms();
    posterior.set_alpha(2);
    posterior.set_beta(1);
    v1::ArmStanding& standing = *response.mutable_posterior_snapshot()->add_standings();
    standing.set_live_window_count(3 + arm);
    standing.set_lane_visit_count(5);
    standing.set_effective_window_count(0.5);
    standing.set_best_probability(0.25);
    standing.mutable_cost_ratio()->set_median(1.5);
    standing.mutable_cost_ratio()->set_low(1.25);
    standing.mutable_cost_ratio()->set_high(2);
  }
  return response;
}

TEST_F(SessionLinkTest, ReturnsTheStandingOfEachArm) {
  GoOnline();
  const size_t arm_count = adaptive_->arms().size();
  ASSERT_TRUE(Receive(SnapshotOf(arm_count)).ok());
  const std::vector<ArmBelief> beliefs = link_.stats().beliefs;
  ASSERT_EQ(beliefs.size(), arm_count);
  ASSERT_TRUE(beliefs[1].standing);
  EXPECT_EQ(beliefs[1].standing->live_window_count, 4U);
  EXPECT_EQ(beliefs[1].standing->lane_visit_count, 5U);
  EXPECT_EQ(beliefs[1].standing->effective_window_count, 0.5);
  EXPECT_EQ(beliefs[1].standing->best_probability, 0.25);
  EXPECT_EQ(beliefs[1].standing->cost_ratio->high, 2);
}

TEST_F(SessionLinkTest, IgnoresStandingsThatAreIncompleteOrOutOfRange) {
  GoOnline();
  const size_t arm_count = adaptive_->arms().size();
  const auto taken = [&](auto change) {
    v1::StreamTelemetryResponse response = SnapshotOf(arm_count);
    change(*response.mutable_posterior_snapshot());
    EXPECT_TRUE(Receive(response).ok());
    EXPECT_EQ(link_.stats().beliefs[0].alpha, 2) << "the posteriors are applied";
    return link_.stats().beliefs[0].standing.has_value();
  };
  EXPECT_TRUE(taken([](v1::PosteriorSnapshot&) {}));
  EXPECT_TRUE(taken([](auto& snapshot) { snapshot.mutable_standings(0)->clear_cost_ratio(); }));
  EXPECT_FALSE(taken([](auto& snapshot) { snapshot.clear_standings(); }));
  EXPECT_FALSE(taken([](auto& snapshot) { snapshot.mutable_standings()->RemoveLast(); }));
  const auto first_taken = [&](auto change) {
    return taken([&](auto& snapshot) { change(*snapshot.mutable_standings(0)); });
  };
  EXPECT_FALSE(first_taken([](auto& standing) { standing.set_best_probability(1.5); }));
  EXPECT_FALSE(first_taken([](auto& standing) { standing.set_best_probability(std::nan("")); }));
  EXPECT_FALSE(first_taken([](auto& standing) { standing.set_effective_window_count(-1); }));
  EXPECT_FALSE(first_taken([](auto& standing) { standing.set_effective_window_count(HUGE_VAL); }));
  EXPECT_FALSE(first_taken([](auto& standing) { standing.mutable_cost_ratio()->set_low(1.75); }));
  EXPECT_FALSE(
      first_taken([](auto& standing) { standing.mutable_cost_ratio()->set_high(HUGE_VAL); }));
}

TEST_F(SessionLinkTest, ReconnectsToADrainingDaemonAfterTheRequestedDelay) {
  GoOnline();
  v1::StreamTelemetryResponse response;
  response.mutable_reconnect()->set_delay_ms(500);
  ASSERT_TRUE(Receive(response).ok());
  Frames(1);
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kFinish);
  EXPECT_EQ(link_.Take(now_ns_), "");
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kNone);
  const auto delay_ms = link_.Disconnected({}, now_ns_);
  ASSERT_TRUE(delay_ms);
  EXPECT_GE(*delay_ms, 500U);
  EXPECT_LE(*delay_ms, 1000U);
  EXPECT_EQ(link_.stats().last_error, "");
  EXPECT_EQ(Connect().session_id(), "a");
}

TEST_F(SessionLinkTest, LimitsTheDelayThatADrainingDaemonRequests) {
  GoOnline();
  v1::StreamTelemetryResponse response;
  response.mutable_reconnect()->set_delay_ms(~0U);
  ASSERT_TRUE(Receive(response).ok());
  EXPECT_LE(link_.Disconnected({}, now_ns_), 5000U);
}

TEST_F(SessionLinkTest, DoesNotResumeAForeignSessionAgain) {
  GoOnline();
  link_.Disconnected(EndWith(kUnavailable, "gone"), now_ns_);
  Connect();
  link_.Disconnected(EndWith(kPermissionDenied, "not yours", "FOREIGN_SESSION"), now_ns_);
  EXPECT_EQ(Connect().session_id(), "");
}

TEST_F(SessionLinkTest, DoesNotReconnectAfterAKick) {
  GoOnline();
  EXPECT_FALSE(link_.Disconnected(EndWith(kPermissionDenied, "enough", "SESSION_KICKED"), now_ns_));
  EXPECT_EQ(link_.stats().last_error, "the daemon refuses the session: enough (SESSION_KICKED)");
}

TEST_F(SessionLinkTest, ReportsWhatTheDaemonDecidesWith) {
  GoOnline();
  EXPECT_EQ(link_.stats().daemon_version, "0.1.0");
  EXPECT_EQ(link_.stats().policy, "paper");
  EXPECT_EQ(link_.stats().seed, 7U);
}

TEST_F(SessionLinkTest, CountsAndSkipsWhatItDoesNotKnow) {
  GoOnline();
  v1::StreamTelemetryResponse response;
  response.GetReflection()->MutableUnknownFields(&response)->AddLengthDelimited(500, "newer");
  response.mutable_switch_command()->set_reason(static_cast<v1::SwitchReason>(99));
  v1::PosteriorSnapshot& snapshot = *response.mutable_posterior_snapshot();
  snapshot.set_verdict(static_cast<v1::Verdict>(99));
  for (int arm = 0; arm < 2; ++arm) {
    snapshot.add_arms()->set_alpha(4);
    snapshot.mutable_arms(arm)->set_beta(2);
  }
  ASSERT_TRUE(Receive(response).ok());
  EXPECT_EQ(link_.stats().unknown_message_count, 3U);
  EXPECT_EQ(link_.stats().command_count, 0U);
  EXPECT_EQ(link_.stats().verdict.verdict, Verdict::kUnknown);
  EXPECT_EQ(link_.stats().beliefs.at(1).alpha, 4) << "only the verdict of the snapshot is unknown";
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kNone);
}

TEST_F(SessionLinkTest, CancelsIfTheWelcomeHasNoSessionId) {
  Connect();
  ASSERT_TRUE(Receive(WelcomeTo("")).ok());
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kCancel);
  link_.Disconnected(EndWith(1, "cancelled"), now_ns_);
  EXPECT_THAT(link_.stats().last_error, HasSubstr("a welcome without a session id"));
  EXPECT_EQ(link_.stats().connection_count, 0U);
}

TEST_F(SessionLinkTest, ReconnectsWithoutLossAfterAnInvalidMessage) {
  GoOnline();
  Frames(2);
  TakeAll();
  const Status status = link_.OnMessage("\x0a\xff", now_ns_);
  EXPECT_EQ(status.code(), StatusCode::kDataLoss);
  EXPECT_THAT(status.message(), HasSubstr("cannot be read"));
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kCancel);
  v1::StreamTelemetryResponse acknowledgement;
  acknowledgement.mutable_acknowledgement()->set_sequence(2);
  EXPECT_TRUE(Receive(acknowledgement).ok()) << "the message is ignored";
  EXPECT_TRUE(link_.Disconnected(EndWith(1, "cancelled"), now_ns_));
  EXPECT_THAT(link_.stats().last_error, HasSubstr("cannot be read; trying again"));
  EXPECT_EQ(Connect().session_id(), "a");
  ASSERT_TRUE(Receive(WelcomeTo("a", true, 0)).ok());
  EXPECT_EQ(TakeAll(), (Sequences{1, 2}));
}

TEST_F(SessionLinkTest, IgnoresOtherMessagesBeforeTheWelcome) {
  Connect();
  v1::StreamTelemetryResponse response;
  response.mutable_switch_command()->set_reason(v1::SWITCH_REASON_POLICY);
  response.mutable_reconnect()->set_delay_ms(1);
  ASSERT_TRUE(Receive(response).ok());
  EXPECT_EQ(link_.stats().command_count, 0U);
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kNone);
}

TEST_F(SessionLinkTest, CancelsIfTheDaemonDoesNotAnswerWithinTenSeconds) {
  Connect();
  EXPECT_EQ(link_.Advance(now_ns_ + 9'999 * kMs), LinkAction::kNone);
  EXPECT_EQ(link_.Advance(now_ns_ + 10'000 * kMs), LinkAction::kCancel);
  link_.Disconnected(EndWith(1, "cancelled"), now_ns_);
  EXPECT_THAT(link_.stats().last_error, HasSubstr("the daemon has not answered; trying again"));
}

TEST_F(SessionLinkTest, SendsTheRestOfTheQueueBeforeItsGoodbye) {
  GoOnline();
  Frames(3);
  link_.Goodbye(now_ns_ + 500 * kMs);
  EXPECT_EQ(Take().sequence(), 1U);
  EXPECT_EQ(Take().sequence(), 2U);
  EXPECT_EQ(Take().sequence(), 3U);
  EXPECT_TRUE(Take().has_goodbye());
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kFinish);
  link_.Take(now_ns_);
  EXPECT_FALSE(link_.finished());
  EXPECT_FALSE(link_.Disconnected({}, now_ns_)) << "no further stream is opened";
  EXPECT_TRUE(link_.finished());
  EXPECT_EQ(link_.stats().last_error, "");
}

TEST_F(SessionLinkTest, SendsItsGoodbyeThoughTheGameContinues) {
  GoOnline();
  Frames(1);
  link_.Goodbye(now_ns_ + 500 * kMs);
  EXPECT_EQ(Take().sequence(), 1U);
  Frames(1);
  EXPECT_TRUE(Take().has_goodbye());
}

TEST_F(SessionLinkTest, SendsAnIncompleteBatchBeforeItsGoodbye) {
  SampleQueue queue(64);
  SessionOptions options = Options();
  options.batch_frames = 240;
  SessionLink link(options, "the daemon", 7, queue, *adaptive_);
  link.Connected(now_ns_);
  link.Advance(now_ns_);
  link.Take(now_ns_);
  ASSERT_TRUE(link.OnMessage(WelcomeTo("a").SerializeAsString(), now_ns_).ok());
  queue.OnFrame(FrameSample{});
  EXPECT_EQ(link.Advance(now_ns_), LinkAction::kNone);
  link.Goodbye(now_ns_ + 500 * kMs);
  ASSERT_EQ(link.Advance(now_ns_), LinkAction::kSend);
  v1::StreamTelemetryRequest request;
  ASSERT_TRUE(request.ParseFromString(link.Take(now_ns_)));
  EXPECT_EQ(request.frame_batch().frame_time_ns_size(), 1);
}

TEST_F(SessionLinkTest, CancelsAGoodbyeAtTheDeadlineAndReportsUnacknowledgedMessages) {
  GoOnline();
  Frames(2);
  TakeAll();
  link_.Goodbye(now_ns_ + 500 * kMs);
  link_.Goodbye(now_ns_ + 800 * kMs);
  EXPECT_EQ(link_.Advance(now_ns_ + 499 * kMs), LinkAction::kSend);
  EXPECT_EQ(link_.Advance(now_ns_ + 500 * kMs), LinkAction::kCancel);
  EXPECT_TRUE(link_.finished());
  EXPECT_EQ(link_.stats().state, ConnectionState::kOffline);
  EXPECT_EQ(link_.Advance(now_ns_ + 501 * kMs), LinkAction::kCancel)
      << "the action repeats until the stream has ended";
  EXPECT_TRUE(link_.connected());
  EXPECT_TRUE(Receive(WelcomeTo("a")).ok()) << "the message is ignored";
  EXPECT_FALSE(link_.Disconnected(EndWith(1, "cancelled"), now_ns_));
  EXPECT_FALSE(link_.connected());
  EXPECT_EQ(link_.Advance(now_ns_ + 502 * kMs), LinkAction::kNone);
  EXPECT_THAT(link_.stats().last_error, HasSubstr("not acknowledged the last 2 messages"));
}

TEST_F(SessionLinkTest, IsFinishedAtOnceWithoutAStream) {
  link_.Goodbye(now_ns_ + 500 * kMs);
  EXPECT_TRUE(link_.finished());
}

TEST_F(SessionLinkTest, RefusesMessagesWithoutAStream) {
  EXPECT_EQ(Receive(WelcomeTo("a")).code(), StatusCode::kFailedPrecondition);
}

TEST_F(SessionLinkTest, KeepsItsSessionWhileNoStreamCanBeOpened) {
  GoOnline();
  link_.Disconnected(EndWith(kUnavailable, "gone"), now_ns_);
  EXPECT_GE(link_.Disconnected(EndWith(0, "no such file"), now_ns_), 500U);
  EXPECT_THAT(link_.stats().last_error, HasSubstr("no such file; trying again in"));
  EXPECT_EQ(Connect().session_id(), "a");
}

TEST_F(SessionLinkTest, RetriesARefusedTokenAfterALongDelay) {
  Connect();
  EXPECT_GE(link_.Disconnected(EndWith(16, "who?", "TOKEN_REFUSED"), now_ns_), 3000U);
  EXPECT_EQ(link_.stats().refusal, "who? (TOKEN_REFUSED)");
}

TEST_F(SessionLinkTest, ReportsWhyTheProtocolWasRefused) {
  Connect();
  EXPECT_TRUE(link_.Disconnected(EndWith(9, "update the older side", "PROTOCOL_VERSION"), now_ns_));
  EXPECT_EQ(link_.stats().refusal, "update the older side (PROTOCOL_VERSION)");
  Connect();
  EXPECT_TRUE(link_.Disconnected(EndWith(9, "no Hello first", "MESSAGE_ORDER"), now_ns_));
  EXPECT_EQ(link_.stats().refusal, "");
}

// HAProxy resets the stream of a refused call, so the client's gRPC reports the reset. The details
// still arrive.
TEST_F(SessionLinkTest, TheDaemonsOwnStatusCountsIfAProxyResetsTheStream) {
  Connect();
  StreamEnd end = EndWith(3, "unknown policy 'x'", "UNKNOWN_POLICY");
  end.code = 1;
  end.message = "Received RST_STREAM with error code 8";
  EXPECT_TRUE(link_.Disconnected(end, now_ns_));
  EXPECT_EQ(link_.stats().refusal, "unknown policy 'x' (UNKNOWN_POLICY)");
  EXPECT_THAT(link_.stats().last_error, HasSubstr("the daemon refuses the session: unknown"));
}

TEST_F(SessionLinkTest, LimitsAnswersThatTheDaemonDoesNotAcknowledge) {
  GoOnline();
  v1::StreamTelemetryResponse order;
  order.mutable_operator_order()->set_order_id(3);
  order.mutable_operator_order()->set_mode(v1::MODE_AI);
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(Receive(order).ok());
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kCancel);
  EXPECT_TRUE(link_.Disconnected(EndWith(1, "cancelled"), now_ns_));
  EXPECT_THAT(link_.stats().last_error,
              HasSubstr("did not acknowledge the game's refusals of orders and commands"));
  Connect();
  ASSERT_TRUE(Receive(WelcomeTo("a", true, 0)).ok());
  EXPECT_EQ(TakeAll().size(), Options().unacknowledged_messages);
}

TEST_F(SessionLinkTest, LimitsAnswersToCommandsWithAnUnknownArm) {
  GoOnline();
  v1::StreamTelemetryResponse command;
  command.mutable_switch_command()->set_arm(99);
  command.mutable_switch_command()->set_reason(v1::SWITCH_REASON_POLICY);
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(Receive(command).ok());
  EXPECT_EQ(link_.Advance(now_ns_), LinkAction::kCancel);
}

TEST_F(SessionLinkTest, ReportsAStatusMessageAsOneLine) {
  Connect();
  link_.Disconnected(EndWith(13, "bad \xff\n\x1b[31m text"), now_ns_);
  EXPECT_THAT(link_.stats().last_error, HasSubstr(": bad ???[31m text; trying again"));
  link_.Disconnected(EndWith(0, "no such\nfile"), now_ns_);
  EXPECT_THAT(link_.stats().last_error, HasSubstr("no such?file; trying again"));
  Connect();
  link_.Disconnected(EndWith(16, std::string(100'000, 'x'), "TOKEN_REFUSED"), now_ns_);
  EXPECT_EQ(link_.stats().refusal, std::string(256, 'x') + " (TOKEN_REFUSED)");
  Connect();
  link_.Disconnected(EndWith(16, "f\u00fcr dich"), now_ns_);
  EXPECT_EQ(link_.stats().refusal, "f\u00fcr dich");
}

TEST_F(SessionLinkTest, ReconnectsSoonAfterAWorkingConnection) {
  for (int i = 0; i < 8; ++i) {
    GoOnline();
    now_ns_ += 1000 * kMs;
    EXPECT_LE(link_.Disconnected(EndWith(kUnavailable, "gone"), now_ns_), 100U);
  }
}

}  // namespace
}  // namespace sweepstake
