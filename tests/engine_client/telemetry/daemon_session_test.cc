// Tests the session over real gRPC on the loopback, with a daemon that each test scripts. Tests
// wait for conditions, not for fixed times; a wait that fails ends with the test's time limit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "engine_client/adaptive/adaptive_factory.h"
#include "sweepstake/adaptive_session.h"
#include "sweepstake/session.h"
#include "tests/support/child_process.h"
#include "tests/support/fake_daemon.h"
#include "tests/support/scripted_broad_phase.h"
#include "tests/support/wait_counter.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::FakeDaemon;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;
using test_support::WaitCounter;
using ::testing::HasSubstr;

constexpr uint64_t kMs = 1'000'000;

class DaemonSessionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.project = "game";
    options_.scene = "hurricane";
    options_.batch_interval_ms = 1;
    options_.backoff_min_ms = 1;
    options_.backoff_max_ms = 20;
  }
  void TearDown() override {
    if (session_) session_->Stop(0);
  }

  void Make(const std::string& address) {
    arms_.clear();
    auto made = MakeDaemonSession(address, options_);
    ASSERT_TRUE(made.ok()) << made.status().message();
    session_ = std::move(*made);
    std::vector<std::unique_ptr<BroadPhase>> backends;
    for (const char* name : {"A", "B", "C"}) {
      auto backend =
          std::make_unique<ScriptedBroadPhase>(ArmScript{.name = name, .version = 7}, clock_);
      arms_.push_back(backend.get());
      backends.push_back(std::move(backend));
    }
    adaptive_ = std::move(
        *AdaptiveFactory::Make(adaptive_options_, std::move(backends), &session_->sink(), clock_));
  }

  void StartAgainst(FakeDaemon& daemon) {
    daemon.Start();
    Make(daemon.address());
    ASSERT_TRUE(session_->Start(*adaptive_).ok());
  }
  void GoOnline(FakeDaemon& daemon) {
    StartAgainst(daemon);
    RunUntilState(ConnectionState::kOnline);
  }

  // Runs one frame and counts the calls that could have blocked it.
  void Frame(uint64_t frame_time_ns = 10 * kMs) {
    const WaitCounter waits;
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes_);
    adaptive_->EndFrame({.frame_time_ns = frame_time_ns});
    wait_count_ += waits.count();
    ++frame_count_;
  }

  // Runs frames until the condition holds.
  template <typename Condition>
  void RunUntil(Condition condition) {
    while (!condition()) {
      Frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void RunUntilState(ConnectionState state) {
    RunUntil([&] { return session_->stats().state == state; });
  }

  // Returns the number of frames in the messages that the daemon received. A message that was sent
  // twice counts once.
  static uint64_t FramesIn(const std::vector<v1::StreamTelemetryRequest>& evidence) {
    uint64_t count = 0;
    for (const auto& request : evidence) count += request.frame_batch().frame_time_ns_size();
    return count;
  }
  static void ExpectFramesWithoutGaps(const std::vector<v1::StreamTelemetryRequest>& evidence) {
    uint64_t sequence = 0;
    for (const auto& request : evidence) {
      EXPECT_EQ(request.sequence(), ++sequence);
      EXPECT_EQ(request.frame_batch().dropped_frame_count(), 0U);
    }
  }

  v1::StreamTelemetryResponse CommandFor(uint32_t arm, uint64_t id = 1) {
    v1::StreamTelemetryResponse response;
    response.mutable_switch_command()->set_command_id(id);
    response.mutable_switch_command()->set_arm(arm);
    response.mutable_switch_command()->set_reason(v1::SWITCH_REASON_POLICY);
    return response;
  }

  SessionOptions options_;
  AdaptiveOptions adaptive_options_ = {.settling_ns = 0};
  ScriptedClock clock_;
  std::vector<Aabb> boxes_{3};
  std::vector<ScriptedBroadPhase*> arms_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  uint64_t frame_count_ = 0;
  uint64_t wait_count_ = 0;
};

TEST_F(DaemonSessionTest, TheHelloDescribesTheSession) {
  options_.build = "1.2.3";
  options_.machine_class = "desktop";
  options_.policy = "paper";
  options_.time_scale = 60;
  options_.seed = 42;
  options_.ignore_priors = true;
  FakeDaemon daemon;
  StartAgainst(daemon);
  daemon.WaitUntil([](const FakeDaemon& d) { return !d.hellos.empty(); });
  RunUntilState(ConnectionState::kOnline);
  session_->Stop();
  daemon.Kill();
  const v1::Hello& hello = daemon.hellos[0];
  EXPECT_EQ(hello.protocol_version(), 1U);
  EXPECT_EQ(hello.project(), "game");
  EXPECT_EQ(hello.scene(), "hurricane");
  EXPECT_EQ(hello.build(), "1.2.3");
  EXPECT_EQ(hello.machine_class(), "desktop");
  EXPECT_EQ(hello.policy(), "paper");
  EXPECT_EQ(hello.time_scale(), 60);
  EXPECT_EQ(hello.seed(), 42U);
  EXPECT_TRUE(hello.ignore_priors());
  EXPECT_EQ(hello.mode(), v1::MODE_AI);
  ASSERT_EQ(hello.arms_size(), 3);
  EXPECT_EQ(hello.arms(1).name(), "B");
  EXPECT_EQ(hello.arms(1).backend_version(), 7U);
}

TEST_F(DaemonSessionTest, TheHelloHasOnlyTheRulesThatTheGameSets) {
  for (const bool sets : {false, true}) {
    if (sets) {
      options_.rules = {.weights = RewardWeights{0.25, 0.25, 0.5, 0},
                        .decision_interval_ns = 500 * kMs,
                        .cooldown_ns = 0,
                        .settling_ns = 3};
    }
    FakeDaemon daemon;
    GoOnline(daemon);
    session_->Stop();
    daemon.Kill();
    const v1::Hello& hello = daemon.hellos[0];
    EXPECT_EQ(hello.has_weights(), sets);
    EXPECT_EQ(hello.has_decision_interval_ns(), sets);
    EXPECT_EQ(hello.has_cooldown_ns(), sets);
    EXPECT_EQ(hello.has_settling_ns(), sets);
    if (!sets) continue;
    EXPECT_EQ(hello.weights().fps(), 0.25);
    EXPECT_EQ(hello.weights().memory(), 0.5);
    EXPECT_EQ(hello.decision_interval_ns(), 500 * kMs);
    EXPECT_EQ(hello.cooldown_ns(), 0U);
    EXPECT_EQ(hello.settling_ns(), 3U);
  }
}

TEST_F(DaemonSessionTest, ItsStatsHaveTheRulesOfTheWelcome) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) {
    script.welcome.set_decision_interval_ms(500);
    script.welcome.set_cooldown_ms(7);
    script.welcome.mutable_weights()->set_fps(1);
  });
  GoOnline(daemon);
  session_->Stop();
  EXPECT_EQ(session_->stats().rules, (DecisionRules{.weights = RewardWeights{1, 0, 0, 0},
                                                    .decision_interval_ns = 500 * kMs,
                                                    .cooldown_ns = 7 * kMs,
                                                    .settling_ns = 0}));
}

TEST_F(DaemonSessionTest, TheLaneRestsWithAPolicyThatDoesNotUseIt) {
  for (const std::string policy : {"paper", "adaptive", "newer"}) {
    FakeDaemon daemon;
    daemon.SetScript([&](auto& script) { script.welcome.set_policy(policy); });
    daemon.Start();
    auto game = AdaptiveSession::Create(MakeDaemonSession(daemon.address(), options_));
    ASSERT_TRUE(game.ok()) << game.status().message();
    while (game->session().stats().connection_count == 0) std::this_thread::yield();
    EXPECT_EQ(game->broad_phase().shadow_stats().state == ShadowState::kPaused, policy == "paper");
    game->session().Stop();
    daemon.Kill();
  }
}

TEST(DaemonSessionRules, AreChecked) {
  const auto error_of = [](const DecisionRules& rules) {
    return MakeDaemonSession("127.0.0.1:1", {.rules = rules}).status().message();
  };
  EXPECT_EQ(error_of({.weights = RewardWeights{1, 1, 0, 0}}),
            "the reward weights sum to 2.000000; make them sum to 1");
  EXPECT_THAT(error_of({.decision_interval_ns = 0}), HasSubstr("decision_interval_ns is 0"));
  EXPECT_THAT(error_of({.cooldown_ns = UINT64_MAX}), HasSubstr("(100 days)"));
  EXPECT_TRUE(MakeDaemonSession("127.0.0.1:1", {.rules = {.cooldown_ns = 0}}).ok());
}

TEST_F(DaemonSessionTest, SendsEveryFrameOnceInOrderAndSaysGoodbye) {
  FakeDaemon daemon;
  GoOnline(daemon);
  for (int i = 0; i < 500; ++i) Frame();
  session_->Stop(60'000);
  daemon.Kill();
  EXPECT_EQ(daemon.goodbyes.size(), 1U);
  EXPECT_EQ(FramesIn(daemon.evidence), frame_count_);
  ExpectFramesWithoutGaps(daemon.evidence);
  const SessionStats stats = session_->stats();
  EXPECT_EQ(stats.state, ConnectionState::kClosed);
  EXPECT_EQ(stats.sent_frame_count, frame_count_);
  EXPECT_EQ(stats.dropped_frame_count, 0U);
  EXPECT_EQ(stats.acknowledged_sequence, stats.sent_sequence);
  EXPECT_EQ(stats.last_error, "");
  EXPECT_EQ(wait_count_, 0U);
}

TEST_F(DaemonSessionTest, ReportsAtItsEndThatTheLastEvidenceIsNotOnDisk) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) { script.farewell = {grpc::StatusCode::UNAVAILABLE, "full"}; });
  GoOnline(daemon);
  session_->Stop(60'000);
  EXPECT_THAT(session_->stats().last_error, HasSubstr("did not confirm the session's end: full"));
}

TEST_F(DaemonSessionTest, ReportsUnacknowledgedMessagesAtItsEnd) {
  options_.unacknowledged_messages = 1;
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) { script.acknowledges = false; });
  GoOnline(daemon);
  RunUntil([&] { return session_->stats().awaits_acknowledgement; });
  session_->Stop(20);
  EXPECT_THAT(session_->stats().last_error, HasSubstr("in time: it has not acknowledged the last"));
}

TEST_F(DaemonSessionTest, PassesACommandToTheFrameThreadAndReturnsItsOutcome) {
  FakeDaemon daemon;
  GoOnline(daemon);
  ASSERT_TRUE(daemon.Send(CommandFor(2, 5)));
  RunUntil([&] { return adaptive_->active_arm() == 2; });
  daemon.WaitUntil([&](const FakeDaemon& d) {
    return std::any_of(d.evidence.begin(), d.evidence.end(), [](const auto& request) {
      return request.switch_outcome().command_id() == 5 && request.switch_outcome().executed();
    });
  });
  EXPECT_EQ(session_->stats().command_count, 1U);
  EXPECT_EQ(wait_count_, 0U);
}

TEST_F(DaemonSessionTest, RefusesACommandForAnArmItDoesNotHave) {
  FakeDaemon daemon;
  GoOnline(daemon);
  ASSERT_TRUE(daemon.Send(CommandFor(3, 5)));
  daemon.WaitUntil([&](const FakeDaemon& d) {
    return std::any_of(d.evidence.begin(), d.evidence.end(), [](const auto& request) {
      return request.switch_outcome().command_id() == 5 && !request.switch_outcome().executed();
    });
  });
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
}

TEST_F(DaemonSessionTest, ReportsABailOutWithoutWaitingForTheBatch) {
  options_.batch_interval_ms = 10'000;
  FakeDaemon daemon;
  GoOnline(daemon);
  Frame(6'000 * kMs);
  daemon.WaitUntil(
      [](const FakeDaemon& d) { return !d.evidence.empty() && d.evidence.back().has_bail_out(); });
}

TEST_F(DaemonSessionTest, UsesTheBatchIntervalOfTheAcknowledgement) {
  options_.batch_interval_ms = 10'000;
  FakeDaemon daemon;
  GoOnline(daemon);
  Frame();
  v1::StreamTelemetryResponse response;
  response.mutable_acknowledgement()->set_batch_interval_ms(1);
  ASSERT_TRUE(daemon.Send(response));
  daemon.WaitUntil([](const FakeDaemon& d) { return !d.evidence.empty(); });
}

TEST_F(DaemonSessionTest, EndsWithItsBroadPhase) {
  FakeDaemon daemon;
  GoOnline(daemon);
  adaptive_.reset();
  EXPECT_EQ(session_->stats().state, ConnectionState::kClosed);
}

TEST_F(DaemonSessionTest, MayEndDuringAFrameBeforeOrAfterItsBroadPhase) {
  for (const bool session_first : {false, true}) {
    FakeDaemon daemon;
    GoOnline(daemon);
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes_);
    if (session_first) {
      session_.reset();
      adaptive_->EndFrame({.frame_time_ns = 10 * kMs});
    }
    adaptive_.reset();
    session_.reset();
  }
}

TEST_F(DaemonSessionTest, SendsAModeChangeInOrderWithTheFrames) {
  FakeDaemon daemon;
  GoOnline(daemon);
  adaptive_->SetMode(Mode::kManual);
  daemon.WaitUntil([](const FakeDaemon& d) {
    return std::any_of(d.evidence.begin(), d.evidence.end(), [](const auto& request) {
      return request.mode_change().mode() == v1::MODE_MANUAL;
    });
  });
}

TEST_F(DaemonSessionTest, AppliesBeliefsSettlingTimeAndPriorsOfTheDaemon) {
  FakeDaemon daemon;
  daemon.SetScript([](FakeDaemon::Script& script) {
    script.welcome.set_prior_source_count(3);
    script.welcome.set_priors_unavailable(true);
    for (int i = 0; i < 3; ++i) {
      v1::BetaPosterior& prior = *script.welcome.add_priors();
      prior.set_alpha(2);
      prior.set_beta(1);
    }
  });
  GoOnline(daemon);
  EXPECT_EQ(session_->stats().prior_source_count, 3U);
  EXPECT_TRUE(session_->stats().priors_unavailable);
  ASSERT_EQ(session_->stats().beliefs.size(), 3U);
  EXPECT_EQ(session_->stats().beliefs[1].arm, "B");
  EXPECT_EQ(session_->stats().beliefs[1].alpha, 2);
  v1::StreamTelemetryResponse response;
  for (int i = 0; i < 3; ++i) {
    v1::BetaPosterior& posterior = *response.mutable_posterior_snapshot()->add_arms();
    posterior.set_alpha(i + 1);
    posterior.set_beta(4);
  }
  ASSERT_TRUE(daemon.Send(response));
  RunUntil([&] { return session_->stats().beliefs[2].alpha == 3; });

  // Snapshots with too few arms or without a distribution are ignored; the last valid one stays.
  response.mutable_posterior_snapshot()->mutable_arms(0)->set_alpha(-1);
  ASSERT_TRUE(daemon.Send(response));
  response.mutable_posterior_snapshot()->mutable_arms()->RemoveLast();
  ASSERT_TRUE(daemon.Send(response));
  ASSERT_TRUE(daemon.Send(CommandFor(1)));
  RunUntil([&] { return session_->stats().command_count == 1; });
  EXPECT_EQ(session_->stats().beliefs.size(), 3U);
  EXPECT_EQ(session_->stats().beliefs[0].alpha, 1);
}

TEST_F(DaemonSessionTest, ReturnsTheVerdictOfTheDaemon) {
  FakeDaemon daemon;
  GoOnline(daemon);
  EXPECT_EQ(session_->stats().verdict.verdict, Verdict::kUnknown);

  v1::StreamTelemetryResponse response;
  v1::PosteriorSnapshot& snapshot = *response.mutable_posterior_snapshot();
  snapshot.set_verdict(v1::VERDICT_TIE);
  snapshot.set_leader_arm(2);
  snapshot.set_leader_probability(0.625);
  ASSERT_TRUE(daemon.Send(response));
  RunUntil([&] { return session_->stats().verdict.verdict == Verdict::kTie; });
  EXPECT_EQ(session_->stats().verdict.leader_arm, 2U);
  EXPECT_EQ(session_->stats().verdict.leader_probability, 0.625);
  EXPECT_EQ(adaptive_->verdict().verdict, Verdict::kTie);
  EXPECT_EQ(adaptive_->verdict().leader_probability, 0.625);

  // Verdicts with an unknown arm, an invalid probability or an unknown kind are ignored; the last
  // valid one stays.
  snapshot.set_verdict(v1::VERDICT_STABLE);
  snapshot.set_leader_arm(3);
  ASSERT_TRUE(daemon.Send(response));
  snapshot.set_leader_arm(1);
  snapshot.set_leader_probability(std::nan(""));
  ASSERT_TRUE(daemon.Send(response));
  snapshot.set_leader_probability(0.5);
  snapshot.set_verdict(static_cast<v1::Verdict>(5));
  ASSERT_TRUE(daemon.Send(response));
  ASSERT_TRUE(daemon.Send(CommandFor(1)));
  RunUntil([&] { return session_->stats().command_count == 1; });
  EXPECT_EQ(session_->stats().verdict.verdict, Verdict::kTie);
  EXPECT_EQ(session_->stats().verdict.leader_arm, 2U);
}

TEST_F(DaemonSessionTest, ConnectsToADaemonThatStartsLater) {
  FakeDaemon daemon;
  daemon.Start();
  const int port = daemon.port();
  daemon.Kill();
  Make(daemon.address());
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  RunUntil([&] { return !session_->stats().last_error.empty(); });
  EXPECT_THAT(session_->stats().last_error, HasSubstr("trying again"));
  daemon.Start(port);
  RunUntilState(ConnectionState::kOnline);
  EXPECT_EQ(session_->stats().last_error, "");
  session_->Stop(60'000);
  daemon.Kill();
  EXPECT_EQ(FramesIn(daemon.evidence), frame_count_);
  EXPECT_EQ(wait_count_, 0U);
}

TEST_F(DaemonSessionTest, ResumesAfterTheDaemonWasKilledWithoutDuplicates) {
  FakeDaemon daemon;
  GoOnline(daemon);
  for (int round = 0; round < 3; ++round) {
    const size_t hello_count = static_cast<size_t>(round) + 1;
    RunUntil([&, frames = frame_count_] { return frame_count_ == frames + 50; });
    daemon.SetScript([](auto& script) { script.acknowledges = false; });
    RunUntil([&, frames = frame_count_] { return frame_count_ == frames + 50; });
    const int port = daemon.port();
    daemon.Kill();
    daemon.SetScript([](auto& script) { script.acknowledges = true; });
    RunUntil([&, frames = frame_count_] { return frame_count_ == frames + 20; });
    daemon.Start(port);
    RunUntil([&] { return session_->stats().resumed_count == hello_count; });
  }
  session_->Stop(60'000);
  daemon.Kill();
  const auto evidence = daemon.Evidence();
  EXPECT_EQ(FramesIn(evidence), frame_count_);
  ExpectFramesWithoutGaps(evidence);
  EXPECT_GT(daemon.evidence.size(), evidence.size());  // evidence was sent again
  EXPECT_EQ(daemon.hellos.back().session_id(), "session-1");
  EXPECT_GT(session_->stats().resent_message_count, 0U);
  EXPECT_EQ(wait_count_, 0U);
}

TEST_F(DaemonSessionTest, EveryHelloHasTheArmWithWhichTheGameBegan) {
  adaptive_options_.initial_arm = "B";
  FakeDaemon daemon;
  GoOnline(daemon);
  ASSERT_TRUE(daemon.Send(CommandFor(2)));
  RunUntil([&] { return adaptive_->active_arm() == 2; });
  // A Hello describes the first frame that is not acknowledged, so wait for the earlier ones.
  uint64_t switch_sequence = 0;
  daemon.WaitUntil([&](const FakeDaemon& d) {
    for (const auto& request : d.evidence)
      if (request.has_switch_outcome()) switch_sequence = request.sequence();
    return switch_sequence > 0;
  });
  RunUntil([&] { return session_->stats().acknowledged_sequence >= switch_sequence; });
  const int port = daemon.port();
  daemon.Kill();
  daemon.Start(port);
  RunUntil([&] { return session_->stats().connection_count == 2; });
  daemon.Kill();
  EXPECT_EQ(daemon.hellos.back().active_arm(), 2U);
  EXPECT_EQ(daemon.hellos.back().initial_arm(), 1U);
}

TEST_F(DaemonSessionTest, AppliesTheBailOutLimitOfTheDaemonToTheFramePath) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) { script.welcome.set_bail_out_ms(100); });
  GoOnline(daemon);
  Frame(100 * kMs);
  EXPECT_EQ(adaptive_->last_sample().flags & kFrameBailOut, 0U);
  Frame(101 * kMs);
  EXPECT_NE(adaptive_->last_sample().flags & kFrameBailOut, 0U);
}

TEST_F(DaemonSessionTest, BeginsANewSessionWhenTheDaemonForgotTheOldOne) {
  FakeDaemon daemon;
  GoOnline(daemon);
  RunUntil([&] { return session_->stats().acknowledged_sequence >= 3; });
  const int port = daemon.port();
  daemon.Kill();
  daemon.ForgetSessions();
  daemon.Start(port);
  RunUntil([&] { return session_->stats().session_id == "session-2"; });
  RunUntil([&] { return session_->stats().acknowledged_sequence >= 1; });
  EXPECT_EQ(session_->stats().resumed_count, 0U);
  EXPECT_EQ(session_->stats().connection_count, 2U);
}

TEST_F(DaemonSessionTest, DropsTheOldestFramesIfTheDaemonNeverReads) {
  options_.queue_frames = 64;
  options_.unacknowledged_messages = 4;
  options_.batch_frames = 5;
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) { script.never_reads = true; });
  GoOnline(daemon);
  RunUntil([&] { return session_->stats().dropped_frame_count > 200; });
  EXPECT_LE(session_->stats().sent_sequence, 6U);
  EXPECT_EQ(wait_count_, 0U);
  daemon.SetScript([](auto& script) { script.never_reads = false; });
  RunUntil([&] { return session_->stats().acknowledged_sequence > 20; });
  session_->Stop(60'000);
  daemon.Kill();
  uint64_t told_dropped = 0;
  for (const auto& request : daemon.evidence) {
    told_dropped += request.frame_batch().dropped_frame_count();
  }
  EXPECT_EQ(told_dropped, session_->stats().dropped_frame_count);
  EXPECT_EQ(FramesIn(daemon.evidence) + told_dropped, frame_count_);
}

TEST_F(DaemonSessionTest, StopsInTimeHoweverTheDaemonBehaves) {
  for (const bool answers_hello : {true, false}) {
    FakeDaemon daemon;
    daemon.SetScript([&](auto& script) {
      script.answers_hello = answers_hello;
      script.never_reads = true;
    });
    StartAgainst(daemon);
    daemon.WaitUntil([](const FakeDaemon& d) { return !d.hellos.empty(); });
    if (answers_hello) RunUntilState(ConnectionState::kOnline);
    for (int i = 0; i < 100; ++i) Frame();
    session_->Stop(20);
    EXPECT_EQ(session_->stats().state, ConnectionState::kClosed);
    EXPECT_THAT(session_->stats().last_error, HasSubstr(answers_hello ? "confirm" : "answered"));
    session_->Stop(20);
  }
  Make("127.0.0.1:1");
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  session_->Stop(20);
}

TEST_F(DaemonSessionTest, ReportsARefusalAndWaitsLongBeforeReconnecting) {
  options_.backoff_max_ms = 3'600'000;
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) {
    script.refusal = grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "protocol 2 only");
  });
  StartAgainst(daemon);
  RunUntil([&] { return !session_->stats().last_error.empty(); });
  EXPECT_THAT(session_->stats().last_error, HasSubstr("protocol 2 only"));
  EXPECT_THAT(session_->stats().last_error, HasSubstr("refuses"));
  EXPECT_EQ(session_->stats().state, ConnectionState::kOffline);
  session_->Stop();
  daemon.Kill();
  EXPECT_EQ(daemon.hellos.size(), 1U);
}

TEST_F(DaemonSessionTest, ContinuesWithoutTheRefusedMessage) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) {
    script.acknowledges = false;
    script.refusal_of_evidence = grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no");
  });
  StartAgainst(daemon);
  RunUntil([&] { return session_->stats().dropped_frame_count > 0; });
  daemon.SetScript([](auto& script) {
    script.acknowledges = true;
    script.refusal_of_evidence.reset();
  });
  RunUntil([&] { return session_->stats().acknowledged_sequence > 0; });
}

TEST_F(DaemonSessionTest, ReconnectsWhenADrainingDaemonRequestsIt) {
  FakeDaemon daemon;
  GoOnline(daemon);
  v1::StreamTelemetryResponse response;
  response.mutable_reconnect()->set_delay_ms(1);
  ASSERT_TRUE(daemon.Send(response));
  RunUntil([&] { return session_->stats().resumed_count == 1; });
}

TEST_F(DaemonSessionTest, TheBailOutGuardActsOnlyWithoutADaemon) {
  FakeDaemon daemon;
  GoOnline(daemon);
  for (ScriptedBroadPhase* arm : arms_) arm->script().find_ns = 5'500 * kMs;
  Frame(6'000 * kMs);
  Frame();
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
  daemon.Kill();
  while (session_->stats().state == ConnectionState::kOnline) std::this_thread::yield();
  Frame(6'000 * kMs);
  Frame();
  EXPECT_EQ(adaptive_->switch_epoch(), 1U);
}

TEST_F(DaemonSessionTest, CanStartOnlyOnce) {
  Make("127.0.0.1:1");
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  EXPECT_EQ(session_->Start(*adaptive_).code(), StatusCode::kFailedPrecondition);
  session_->Stop();
  EXPECT_EQ(session_->Start(*adaptive_).code(), StatusCode::kFailedPrecondition);
}

TEST(MakeDaemonSession, RefusesBadAddressesAndOptions) {
  EXPECT_EQ(MakeDaemonSession("nowhere", {}).status().code(), StatusCode::kInvalidArgument);
  SessionOptions options;
  options.scene.clear();
  EXPECT_EQ(MakeDaemonSession("localhost:1", options).status().code(),
            StatusCode::kInvalidArgument);
}

#if SWEEPSTAKE_CAN_FORK
// The child has none of the threads of the session and of gRPC.
TEST_F(DaemonSessionTest, AForkedChildDestroysItWithoutWaiting) {
  FakeDaemon daemon;
  GoOnline(daemon);
  EXPECT_EQ(test_support::StatusOfChild([&] {
              session_.reset();
              adaptive_.reset();
            }),
            0);
}
#endif

}  // namespace
}  // namespace sweepstake
