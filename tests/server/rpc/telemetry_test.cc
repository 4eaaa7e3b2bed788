// Tests the telemetry stream: sessions, evidence, acknowledgements.
#include <cmath>
#include <functional>

#include "engine_client/decider/session/policy_registry.h"
#include "server/rpc/health_probe.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;
using ::testing::HasSubstr;

std::vector<uint64_t> ValuesOf(const sessions::RejectionCounts& counts) {
  return {counts.begin(), counts.end()};
}

class TelemetryTest : public RpcTest {};

TEST_F(TelemetryTest, HelloIsAnsweredWithAWelcome) {
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(HelloMessage());
  EXPECT_EQ(welcome.session_id().size(), 32u);
  EXPECT_FALSE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 0u);
  EXPECT_EQ(welcome.max_batch_frames(), 240u);
  EXPECT_EQ(welcome.max_message_bytes(), 256u * 1024);
  EXPECT_EQ(welcome.batch_interval_ms(), 250u);
  EXPECT_EQ(welcome.decision_interval_ms(), 2000u);
  EXPECT_EQ(welcome.bail_out_ms(), 5000u);
  EXPECT_EQ(welcome.policy(), "paper");
  EXPECT_EQ(welcome.daemon_version(), "0.1.0");
  EXPECT_EQ(welcome.seed(), 7u);
  ASSERT_EQ(welcome.priors_size(), 3);
  EXPECT_EQ(welcome.priors(2).alpha(), 1);
  EXPECT_EQ(welcome.priors(2).beta(), 1);
  EXPECT_EQ(welcome.prior_source_count(), 0u);
}

TEST_F(TelemetryTest, TheWelcomeHasTheCapabilitiesThatBothSidesHave) {
  v1::Hello hello = HelloMessage();
  EXPECT_THAT(TelemetryClient(channel_).Open(hello).capabilities(), ::testing::IsEmpty());
  hello.add_capabilities(static_cast<v1::Capability>(99));
  for (int i = 0; i < 2; ++i) hello.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  hello.add_capabilities(v1::CAPABILITY_STOPS_TRIALS);
  const v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_THAT(welcome.capabilities(),
              ::testing::ElementsAre(v1::CAPABILITY_OPERATOR_ORDERS, v1::CAPABILITY_STOPS_TRIALS));
}

TEST_F(TelemetryTest, AClientThatStopsNoTrialsAnyMoreGetsANewSession) {
  v1::Hello hello = HelloMessage();
  hello.add_capabilities(v1::CAPABILITY_STOPS_TRIALS);
  const v1::Welcome first = TelemetryClient(channel_).Open(hello);
  hello.set_session_id(first.session_id());
  hello.set_resume_token(first.resume_token());
  EXPECT_TRUE(TelemetryClient(channel_).Open(hello).resumed());
  hello.clear_capabilities();
  EXPECT_FALSE(TelemetryClient(channel_).Open(hello).resumed());
}

TEST_F(TelemetryTest, AHelloWithoutAPolicyGetsTheDaemonsDefault) {
  StopServer();
  options_.decision.policy = "paper";
  StartServer();
  v1::Hello hello = HelloMessage();
  hello.clear_policy();
  EXPECT_EQ(TelemetryClient(channel_).Open(hello).policy(), "paper");
  hello.set_policy("adaptive");
  EXPECT_EQ(TelemetryClient(channel_).Open(hello).policy(), "adaptive");
}

// The setup row of the audit log and the welcome have the options of the session.
TEST_F(TelemetryTest, ASessionUsesTheRulesOfItsHello) {
  StopServer();
  options_.max_time_scale = 2;
  StartServer();
  v1::Hello hello = HelloMessage();
  v1::RewardWeights& weights = *hello.mutable_weights();
  weights.set_fps(0.25);
  weights.set_detection(0.25);
  weights.set_memory(0.5);
  hello.set_decision_interval_ns(kSecondNs);
  hello.set_cooldown_ns(8 * kSecondNs);
  hello.set_settling_ns(0);
  hello.set_time_scale(2);
  TelemetryClient client(channel_);
  const v1::Welcome welcome = LearnOneWindow(client, hello);
  EXPECT_EQ(welcome.decision_interval_ms(), 500u);
  EXPECT_EQ(welcome.cooldown_ms(), 4000u);
  EXPECT_EQ(welcome.settling_ms(), 0u);
  EXPECT_EQ(welcome.weights().memory(), 0.5);
  EXPECT_EQ(welcome.weights().checks(), 0);
  const std::vector<decision::AuditRow> rows = ExportAudit();
  const decision::DecisionOptions& logged = rows.at(0).setup->setup.options;
  EXPECT_EQ(logged.weights, (RewardWeights{0.25, 0.25, 0.5, 0}));
  EXPECT_EQ(logged.decision_interval_ns, kSecondNs / 2);
  EXPECT_EQ(logged.cooldown_ns, 4 * kSecondNs);
  EXPECT_EQ(logged.settling_ns, 0);
  EXPECT_GE(rows.at(1).decision->reward_version, decision::kFirstOwnRewardVersion);
}

TEST_F(TelemetryTest, AHelloWithoutRulesGetsThoseOfTheDaemon) {
  StopServer();
  options_.decision.weights = {0.25, 0.25, 0.5, 0};
  options_.decision.cooldown_ns = 9 * kSecondNs;
  StartServer();
  const v1::Welcome welcome = TelemetryClient(channel_).Open(HelloMessage());
  EXPECT_EQ(welcome.cooldown_ms(), 9000u);
  EXPECT_EQ(welcome.decision_interval_ms(), 2000u);
  EXPECT_EQ(welcome.weights().memory(), 0.5);
}

TEST_F(TelemetryTest, RulesOutOfRangeAreInvalid) {
  const auto error_of = [&](const std::function<void(v1::Hello&)>& change) {
    v1::Hello hello = HelloMessage();
    change(hello);
    TelemetryClient client(channel_);
    client.Send(Request(hello));
    const grpc::Status status = client.Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_INVALID_MESSAGE);
    return status.error_message();
  };
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.mutable_weights()->set_fps(0.5); }),
              HasSubstr("the reward weights sum to 0.5"));
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.mutable_weights()->set_fps(NAN); }),
              HasSubstr("use numbers from 0 to 1"));
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.set_decision_interval_ns(249'999'999); }),
              HasSubstr("use 250000000 or more"));
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.set_decision_interval_ns(0); }),
              HasSubstr("decision_interval_ns is 0"));
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.set_cooldown_ns(UINT64_MAX); }),
              HasSubstr("cooldown_ns"));
  EXPECT_THAT(error_of([](v1::Hello& hello) { hello.set_settling_ns(UINT64_MAX); }),
              HasSubstr("settling_ns"));
}

TEST_F(TelemetryTest, TheTimeScaleDividesTheIntervalsOfTheWelcome) {
  StopServer();
  options_.max_time_scale = 100;
  StartServer();
  TelemetryClient client(channel_);
  v1::Hello hello = HelloMessage();
  hello.set_time_scale(100);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_EQ(welcome.decision_interval_ms(), 20u);
  EXPECT_EQ(welcome.bail_out_ms(), 5000u);
  EXPECT_EQ(welcome.batch_interval_ms(), 2u);
}

TEST_F(TelemetryTest, ATimeScaleThatTheDaemonDoesNotAllowEndsTheStream) {
  TelemetryClient client(channel_);
  v1::Hello hello = HelloMessage();
  hello.set_time_scale(2);
  client.Send(Request(hello));
  const grpc::Status status = client.Finish();
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TIME_SCALE);
  EXPECT_THAT(status.error_message(), HasSubstr("--max-time-scale 2"));
}

TEST_F(TelemetryTest, AReplayedMessageIsCountedAndNotAppliedAgain) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  client.Send(Frames(1, 30));
  client.Send(BailOut(2, 5000));
  client.Send(BailOut(2, 5000));
  ASSERT_TRUE(Eventually([&] { return server_->counters().replayed_message_count == 2; }));
  Tick();
  client.AwaitAcknowledgement(2);
  EXPECT_EQ(server_->counters().applied_message_count, 2u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u);
  EXPECT_EQ(Stored().arms[0].live.bail_out_count, 1u);
}

TEST_F(TelemetryTest, ASessionContinuesAfterALostStream) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.Send(Frames(2, 30));
    ASSERT_TRUE(Applied(2));
  }
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.session_id(), hello.session_id());
  EXPECT_EQ(welcome.acknowledged_sequence(), 1u);
  client.Send(Frames(2, 30));
  client.Send(Frames(3, 30));
  ASSERT_TRUE(Applied(3));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(3), 3u);
  EXPECT_EQ(server_->counters().replayed_message_count, 1u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 2u);
}

TEST_F(TelemetryTest, ASessionContinuesAfterARestartWithNothingLostOrDoubled) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.Send(Frames(2, 30));
    ASSERT_TRUE(Applied(2));
  }
  RestartServer();
  TelemetryClient client(channel_);
  hello.set_seed(0);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 1u);
  EXPECT_EQ(welcome.seed(), 7u);
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_NEAR(welcome.priors(0).alpha() + welcome.priors(0).beta(), 3, 1e-12);
  client.Send(Frames(1, 30));
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 2u);
  EXPECT_EQ(Stored().source_count, 1u);
}

TEST_F(TelemetryTest, ASilentSessionIsNotStored) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient ends(channel_);
    ends.Open(hello);
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Tick();
    ends.Send(Goodbye());
    EXPECT_TRUE(ends.Finish().ok());
    client.HalfClose();
    EXPECT_TRUE(client.Finish().ok());
  }
  EXPECT_EQ(server_->counters().decision_count, 0u);
  EXPECT_EQ(server_->counters().waiting_audit_bytes, 0u)
      << "rows that never reach the disk are released";
  {
    TelemetryClient client(channel_);
    EXPECT_TRUE(client.Open(hello).resumed()) << "the session is in memory";
  }
  EXPECT_EQ(server_->counters().stored_commit_count, 0u);
  RestartServer();
  TelemetryClient client(channel_);
  EXPECT_FALSE(client.Open(hello).resumed());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
}

TEST_F(TelemetryTest, ANewSessionStartsFromTheEvidenceOfOthers) {
  {
    TelemetryClient client(channel_);
    LearnOneWindow(client, HelloMessage());
  }
  TelemetryClient second(channel_);
  const v1::Welcome welcome = second.Open(HelloMessage());
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_NEAR(welcome.priors(0).alpha() + welcome.priors(0).beta(), 3, 1e-12);
  v1::Hello hello = HelloMessage();
  hello.set_ignore_priors(true);
  TelemetryClient third(channel_);
  const v1::Welcome flat = third.Open(hello);
  EXPECT_EQ(flat.prior_source_count(), 0u);
  EXPECT_EQ(flat.priors(0).alpha() + flat.priors(0).beta(), 2);
}

TEST_F(TelemetryTest, ASecondConnectionResumesTheSessionAndEndsTheFirst) {
  v1::Hello hello = HelloMessage();
  TelemetryClient first(channel_);
  Resume(hello, first.Open(hello));
  TelemetryClient second(channel_);
  EXPECT_TRUE(second.Open(hello).resumed());
  const grpc::Status status = first.Finish();
  // The welcome message may still be on its way; then the stream is cut off, and its status has no
  // details.
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(server_->counters().error_counts.at(v1::ERROR_REASON_SESSION_TAKEN_OVER), 1u);
  second.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  EXPECT_EQ(second.AwaitAcknowledgement(1), 1u);
}

TEST_F(TelemetryTest, ABailOutIsAnsweredAtOnceAndStoredWithTheNextTick) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  uint64_t sequence = 2;
  client.Send(BailOut(sequence, 5000));
  const v1::PosteriorSnapshot snapshot =
      client.Await(&Response::has_posterior_snapshot).posterior_snapshot();
  EXPECT_EQ(snapshot.arms(0).beta(), 11);
  client.Send(BailOut(++sequence, 5000));
  ASSERT_TRUE(Applied(3));
  EXPECT_TRUE(Stored().arms.empty());
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(3), 3u);
  EXPECT_EQ(Stored().arms[0].live.bail_out_count, 1u);
}

TEST_F(TelemetryTest, AFrameWithinTheLimitIsNotABailOutDespiteItsFlag) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  v1::StreamTelemetryRequest forged = BailOut(1, 5000);
  forged.mutable_bail_out()->set_frame_time_ns(10'000'000);
  forged.mutable_bail_out()->set_detection_time_ns(9'000'000);
  client.Send(forged);
  v1::StreamTelemetryRequest frames = Frames(2, 30);
  for (int i = 0; i < 30; ++i) {
    frames.mutable_frame_batch()->set_flags(i, v1::FRAME_FLAG_BAIL_OUT);
  }
  client.Send(frames);
  ASSERT_TRUE(Applied(2));
  EXPECT_THAT(ValuesOf(server_->counters().rejected_frame_counts),
              ::testing::ElementsAre(1, 0, 0, 0, 0));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_EQ(Stored().arms[0].live.bail_out_count, 0u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u) << "its frames count as ordinary frames";
}

TEST_F(TelemetryTest, ASuspendedFrameIsCountedAndLoggedButIsNotEvidence) {
  TelemetryClient client(channel_);
  const std::string session_id = client.Open(OneArmHello()).session_id();
  v1::StreamTelemetryRequest frames = Frames(1, 3, 6'000);
  for (int i = 0; i < 2; ++i) {
    frames.mutable_frame_batch()->set_flags(i, v1::FRAME_FLAG_SUSPENDED);
  }
  frames.mutable_frame_batch()->set_frame_time_ns(2, 10'000'000);
  frames.mutable_frame_batch()->set_detection_time_ns(2, 5'000'000);
  client.Send(frames);
  client.Send(BailOut(2, 1));
  v1::StreamTelemetryRequest bail_out = BailOut(3, 2);
  bail_out.mutable_bail_out()->set_flags(v1::FRAME_FLAG_BAIL_OUT | v1::FRAME_FLAG_SUSPENDED);
  client.Send(bail_out);
  ASSERT_TRUE(Applied(3));
  EXPECT_EQ(server_->counters().accepted_frame_count, 3u);
  EXPECT_EQ(server_->counters().suspended_frame_count, 2u);
  const std::string note = "session " + session_id + ": its system suspended";
  EXPECT_TRUE(Eventually([&] { return logged_->text().find(note) != std::string::npos; }));
  logged_->Clear();
  frames.set_sequence(4);
  client.Send(frames);
  ASSERT_TRUE(Applied(4));
  EXPECT_EQ(server_->counters().suspended_frame_count, 4u);
  EXPECT_EQ(logged_->text(), "") << "one line per minute";
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(4), 4u);
  EXPECT_EQ(Stored().arms[0].live.bail_out_count, 1u) << "of the frame that was not suspended";
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u);
}

TEST_F(TelemetryTest, InvalidBoxesAreCountedAndLoggedOncePerMinute) {
  TelemetryClient client(channel_);
  const std::string session_id = client.Open(OneArmHello()).session_id();
  const std::string note = "session " + session_id + ": invalid boxes (infinite";
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
    v1::StreamTelemetryRequest frames = Frames(sequence, 3, 10);
    frames.mutable_frame_batch()->set_invalid_box_count(sequence == 1 ? 0 : 7);
    if (sequence == 4) clock_.Advance(60'000'000'000);
    client.Send(frames);
    ASSERT_TRUE(Applied(sequence));
    Tick();  // the log is written after the message was applied
    ASSERT_EQ(client.AwaitAcknowledgement(sequence), sequence);
    EXPECT_EQ(server_->counters().invalid_box_batch_count, sequence - 1);
    const std::string text = logged_->text();
    EXPECT_EQ(text.find(note) != std::string::npos, sequence == 2 || sequence == 4) << sequence;
    EXPECT_EQ(text.find("with nothing: 7 objects") != std::string::npos,
              sequence == 2 || sequence == 4);
    logged_->Clear();
  }
}

TEST_F(TelemetryTest, AFloodOfBailOutsIsAnsweredAndHardlyChangesThePriors) {
  const auto mean_at_start = [this] {
    const v1::Welcome welcome = TelemetryClient(channel_).Open(OneArmHello());
    return welcome.priors(0).alpha() / (welcome.priors(0).alpha() + welcome.priors(0).beta());
  };
  Put({LearntInHours()});
  const double before = mean_at_start();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  const auto believed = static_cast<uint64_t>(decision::BailOutBudget::kBurst);
  for (uint64_t sequence = 1; sequence <= 10 * believed; ++sequence) {
    client.Send(BailOut(sequence, sequence));
  }
  ASSERT_TRUE(Applied(10 * believed));
  EXPECT_EQ(server_->counters().decision_count, 10 * believed);
  EXPECT_EQ(server_->counters().surplus_bail_out_count, 9 * believed);
  Tick();
  client.AwaitAcknowledgement(10 * believed);
  EXPECT_EQ(Stored().arms[0].live.bail_out_count, believed);
  EXPECT_GT(before, mean_at_start());
  EXPECT_LT(before, mean_at_start() + 0.05);
}

TEST_F(TelemetryTest, ALostSwitchCommandIsSentAgain) {
  v1::Hello hello = HelloMessage();
  uint64_t command_id = 0;
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    for (uint64_t sequence = 1; server_->counters().switch_command_count == 0; ++sequence) {
      client.Send(BailOut(sequence, sequence));
      client.Await(&Response::has_posterior_snapshot);
      ASSERT_LT(sequence, 100u);
    }
  }
  TelemetryClient client(channel_);
  client.Open(hello);
  const v1::SwitchCommand command = client.Await(&Response::has_switch_command).switch_command();
  command_id = command.command_id();
  EXPECT_EQ(command.reason(), v1::SWITCH_REASON_BAIL_OUT);
  EXPECT_NE(command.arm(), 0u);
  EXPECT_GT(command_id, 0u);
}

TEST_F(TelemetryTest, ManualModeLearnsNothingAndStillAcknowledges) {
  v1::Hello hello = HelloMessage();
  hello.set_mode(v1::MODE_MANUAL);
  TelemetryClient client(channel_);
  client.Open(hello);
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_TRUE(Stored().arms.empty());
}

TEST_F(TelemetryTest, ImpossibleFramesAreRejectedAndCounted) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  v1::StreamTelemetryRequest request = Frames(1, 30);
  request.mutable_frame_batch()->set_frame_time_ns(0, 1);
  request.mutable_frame_batch()->set_frame_time_ns(1, 3601 * kSecondNs);
  request.mutable_frame_batch()->set_detection_time_ns(2, 20'000'000);
  request.mutable_frame_batch()->set_aabb_check_count(3, 1ull << 60);
  request.mutable_frame_batch()->set_native_bytes(4, 1ull << 46);
  client.Send(request);
  ASSERT_TRUE(Applied(1));
  EXPECT_THAT(ValuesOf(server_->counters().rejected_frame_counts),
              ::testing::ElementsAre(2, 1, 0, 1, 1));
  EXPECT_EQ(server_->counters().accepted_frame_count, 25u);
}

TEST_F(TelemetryTest, MeasurementsOfTheShadowLaneReachThePolicy) {
  TelemetryClient client(channel_);
  v1::Hello hello = HelloMessage();
  hello.set_policy("adaptive");
  client.Open(hello);
  v1::StreamTelemetryRequest request = Frames(1, 30);
  for (const uint32_t arm : {0u, 1u, 2u}) {
    v1::ShadowSample& sample = *request.mutable_frame_batch()->add_shadow_samples();
    sample.set_arm(arm);
    sample.set_detection_time_ns(arm == 2 ? 500'000 : 5'000'000);
    sample.set_frame_count(5);
    sample.set_flags(arm == 0 ? v1::SHADOW_FLAG_ACTIVE : 0);
  }
  client.Send(request);
  ASSERT_TRUE(Applied(1));
  EXPECT_EQ(server_->counters().accepted_shadow_count, 3u);
  Tick();
  const v1::SwitchCommand command = client.Await(&Response::has_switch_command).switch_command();
  EXPECT_EQ(command.arm(), 2u);
  EXPECT_EQ(command.reason(), v1::SWITCH_REASON_POLICY);
}

TEST_F(TelemetryTest, ImpossibleShadowVisitsAreRejectedAndCounted) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  v1::StreamTelemetryRequest request = Frames(1, 30);
  for (int i = 0; i < 4; ++i) {
    request.mutable_frame_batch()->add_shadow_samples()->set_detection_time_ns(1'000'000);
  }
  auto& samples = *request.mutable_frame_batch()->mutable_shadow_samples();
  samples[0].set_detection_time_ns(3601 * kSecondNs);
  samples[1].set_build_time_ns(3601 * kSecondNs);
  samples[2].set_native_bytes(1ull << 46);
  client.Send(request);
  ASSERT_TRUE(Applied(1));
  EXPECT_THAT(ValuesOf(server_->counters().rejected_shadow_counts),
              ::testing::ElementsAre(0, 1, 1, 0, 1));
  EXPECT_EQ(server_->counters().accepted_shadow_count, 1u);
}

TEST_F(TelemetryTest, GoodbyeIsAnsweredWhenEverythingIsOnDisk) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  client.Send(Goodbye());
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_TRUE(client.Finish().ok());
}

TEST_F(TelemetryTest, WithAFullDiskDecisionsContinueAndNothingIsAcknowledgedUntilItRecovers) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  store_.Fail(true);
  for (uint64_t sequence = 1; sequence <= 3; ++sequence) {
    client.Send(Frames(sequence, 30));
    ASSERT_TRUE(Applied(sequence));
    Tick();
    EXPECT_TRUE(client.Read()->has_posterior_snapshot());
    ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count == sequence; }));
  }
  store_.Fail(false);
  client.Send(Frames(4, 30));
  ASSERT_TRUE(Applied(4));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(4), 4u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 4u);
}

TEST_F(TelemetryTest, GoodbyeWithAFullDiskDoesNotHang) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  store_.Fail(true);
  client.Send(Goodbye());
  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(TelemetryTest, HealthFollowsTheStore) {
  // The server checks a second after its last check, which may have been after the clock was
  // advanced.
  const auto health = [&] {
    clock_.Advance(kSecondNs);
    return *HealthOf(channel_, std::chrono::minutes(1));
  };
  EXPECT_EQ(health(), Health::kServing);
  store_.Fail(true);
  EXPECT_TRUE(Eventually([&] { return health() == Health::kNotServing; }));
  store_.Fail(false);
  EXPECT_TRUE(Eventually([&] { return health() == Health::kServing; }));
}

TEST_F(TelemetryTest, ASessionLeavesMemoryAfterItsWindowAndIsResumedFromTheStore) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.HalfClose();
    EXPECT_TRUE(client.Finish().ok());
  }
  clock_.Advance(options_.resume_window_ns);
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 1u);
}

class SessionLimitTest : public TelemetryTest {
 protected:
  SessionLimitTest() { options_.max_sessions = 1; }
};

TEST_F(SessionLimitTest, ANewSessionIsRefusedWhileAllAreConnectedAndReplacesALostOne) {
  TelemetryClient first(channel_);
  first.Open(HelloMessage());
  TelemetryClient second(channel_);
  second.Send(Request(HelloMessage()));
  EXPECT_EQ(ReasonOf(second.Finish()), v1::ERROR_REASON_TOO_MANY_SESSIONS);
  first.HalfClose();
  EXPECT_TRUE(first.Finish().ok());
  TelemetryClient third(channel_);
  EXPECT_FALSE(third.Open(HelloMessage()).resumed());
}

}  // namespace
}  // namespace sweepstake::rpc
