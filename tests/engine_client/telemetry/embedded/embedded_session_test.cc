#include <gtest/gtest.h>

#include <thread>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "sweepstake/adaptive_session.h"
#include "sweepstake/session.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;

// A session with a decider that decides every 2 ms, and a game that runs frames until a condition
// holds.
class EmbeddedSessionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    EmbeddedOptions embedded;
    embedded.policy = "paper";
    embedded.time_scale = 1000;
    auto made = MakeEmbeddedSession(embedded, SessionOptions());
    ASSERT_TRUE(made.ok());
    session_ = std::move(*made);
    std::vector<std::unique_ptr<BroadPhase>> backends;
    for (const char* name : {"Slow", "Fast"}) {
      ArmScript script;
      script.name = name;
      backends.push_back(std::make_unique<ScriptedBroadPhase>(script, clock_));
    }
    adaptive_ =
        std::move(*AdaptiveFactory::Make({}, std::move(backends), &session_->sink(), clock_));
  }

  void Frame() {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes_);
    adaptive_->EndFrame(
        {.frame_time_ns = adaptive_->active_arm() == 0 ? 40'000'000U : 10'000'000U});
  }

  // Loops until the condition holds. If it never does, the test ends by its time limit and not
  // after a number of attempts.
  template <typename Condition>
  void RunUntil(Condition condition) {
    while (!condition()) {
      Frame();
      std::this_thread::yield();
    }
  }

  ScriptedClock clock_;
  std::vector<Aabb> boxes_{3};
  std::unique_ptr<Session> session_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(EmbeddedSessionTest, SwitchesArmsAndReturnsItsBeliefs) {
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  EXPECT_EQ(session_->stats().state, ConnectionState::kEmbedded);
  RunUntil([this] { return adaptive_->switch_epoch() >= 2; });
  RunUntil([this] {
    const SessionStats stats = session_->stats();
    return stats.beliefs.size() == 2 && stats.beliefs[0].alpha > 1 && stats.beliefs[1].alpha > 1;
  });
  session_->Stop();
  const SessionStats stats = session_->stats();
  EXPECT_EQ(stats.state, ConnectionState::kClosed);
  EXPECT_GE(stats.command_count, 2U);
  EXPECT_EQ(stats.beliefs[1].arm, "Fast");
  EXPECT_GT(stats.intake_time_ns, 0U);
  EXPECT_GT(stats.longest_decision_ns, 0U);
  EXPECT_GE(stats.decision_time_ns, stats.longest_decision_ns);
}

TEST_F(EmbeddedSessionTest, ReturnsTheVerdict) {
  EXPECT_EQ(session_->stats().verdict.verdict, Verdict::kUnknown);
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  // Arm 1 is the fast one.
  RunUntil([this] {
    const SceneVerdict verdict = adaptive_->verdict();
    return verdict.verdict == Verdict::kStable && verdict.leader_arm == 1;
  });
  session_->Stop();
  EXPECT_EQ(session_->stats().verdict.verdict, adaptive_->verdict().verdict);
  EXPECT_GE(session_->stats().verdict.leader_probability, 0.8);
}

// Only the latest decision is available, so the test may miss the one with a command.
TEST_F(EmbeddedSessionTest, ReturnsTheLatestDecisionWithReasonsAndSwitchOutcome) {
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  std::optional<LastDecision> decision;
  RunUntil([&] {
    decision = adaptive_->last_decision();
    return decision && decision->candidate_arm && decision->expected_loss_ratio > 0;
  });
  EXPECT_GT(decision->decision_id, 1U);
  EXPECT_LE(decision->time_ns, SteadyClock().NowNs());
  ASSERT_EQ(decision->arm_count, 2U);
  EXPECT_NEAR(decision->best_probability[0] + decision->best_probability[1], 1, 1e-6);
  EXPECT_NE(decision->verdict.verdict, Verdict::kUnknown);
  if (decision->command) {
    EXPECT_EQ(decision->candidate_arm, decision->command->arm);
  }
  std::optional<SwitchOutcome> outcome;
  RunUntil([&] {
    outcome = adaptive_->last_outcome();
    return outcome.has_value();
  });
  EXPECT_GT(outcome->command_id, 0U);
  EXPECT_LT(outcome->arm, 2U);
}

// At this time scale settling takes 2 ms, so that the second frame reports the cost of the switch.
TEST_F(EmbeddedSessionTest, UsesTheSettlingTimeOfItsDecider) {
  adaptive_->SetMode(Mode::kManual);
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  ASSERT_TRUE(adaptive_->SelectArm("Fast").ok());
  Frame();
  EXPECT_FALSE(adaptive_->last_outcome());
  Frame();
  ASSERT_TRUE(adaptive_->last_outcome());
  EXPECT_EQ(adaptive_->last_outcome()->arm, 1U);
}

// The first row of the log has the options of the decider.
TEST(EmbeddedSessionRules, AreThoseOfTheGame) {
  ScriptedClock clock;
  std::string log;
  auto session = MakeEmbeddedSession({.policy = "paper",
                                      .weights = {0.25, 0.25, 0.5, 0},
                                      .decision_interval_ns = 500'000'000,
                                      .cooldown_ns = 0,
                                      .settling_ns = 3,
                                      .on_audit_row = [&](std::string_view row) { log += row; }});
  ASSERT_TRUE(session.ok());
  std::vector<std::unique_ptr<BroadPhase>> backends;
  backends.push_back(std::make_unique<ScriptedBroadPhase>(ArmScript{.name = "A"}, clock));
  const auto adaptive =
      std::move(*AdaptiveFactory::Make({}, std::move(backends), &(*session)->sink(), clock));
  ASSERT_TRUE((*session)->Start(*adaptive).ok());
  (*session)->Stop();
  EXPECT_NE(log.find(",paper,0.25,0.25,0.5,0,500000000,0,3,"), std::string::npos) << log;
}

TEST(EmbeddedSessionRules, AreChecked) {
  const auto error_of = [](const EmbeddedOptions& options) {
    auto game = AdaptiveSession::Create(MakeEmbeddedSession(options));
    return game.status().message();
  };
  EXPECT_EQ(error_of({.weights = {1, 1, 0, 0}}),
            "the reward weights sum to 2.000000; make them sum to 1");
  EXPECT_EQ(error_of({.weights = {-1, 1, 1, 0}}),
            "a reward weight is negative or not finite; use numbers from 0 to 1");
  EXPECT_EQ(error_of({.decision_interval_ns = 0}), "decision_interval_ns is 0; use 1 or more");
}

TEST_F(EmbeddedSessionTest, ExportsPriorsWhileItRunsAndAfterItsEnd) {
  EXPECT_EQ(session_->ExportPriors().status().code(), StatusCode::kFailedPrecondition);
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  RunUntil([this] { return ParsePriors(*session_->ExportPriors())->size() == 2; });
  session_->Stop();
  const auto records = ParsePriors(*session_->ExportPriors());
  ASSERT_TRUE(records.ok()) << records.status().message();
  EXPECT_EQ(records->size(), 2U);
}

TEST_F(EmbeddedSessionTest, ReadsEveryFrameFromTheQueueBeforeItStops) {
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  for (int i = 0; i < 1000; ++i) Frame();
  session_->Stop();
  const SessionStats stats = session_->stats();
  EXPECT_EQ(stats.sent_frame_count + stats.dropped_frame_count, 1000U);
}

TEST_F(EmbeddedSessionTest, CommandsNothingAfterAChangeToManualMode) {
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  RunUntil([this] { return adaptive_->switch_epoch() >= 1; });
  adaptive_->SetMode(Mode::kManual);
  const uint32_t epoch = adaptive_->switch_epoch();
  for (int i = 0; i < 2000; ++i) Frame();
  EXPECT_EQ(adaptive_->switch_epoch(), epoch);
}

TEST_F(EmbeddedSessionTest, CannotStartAgainAfterAStop) {
  ASSERT_TRUE(session_->Start(*adaptive_).ok());
  EXPECT_EQ(session_->Start(*adaptive_).code(), StatusCode::kFailedPrecondition);
  session_->Stop();
  session_->Stop();
  EXPECT_EQ(session_->Start(*adaptive_).code(), StatusCode::kFailedPrecondition);
  Frame();
}

TEST(EmbeddedSessionStart, ReportsInvalidPriors) {
  EmbeddedOptions embedded;
  embedded.priors_file = "no/such/file.json";
  auto session = MakeEmbeddedSession(embedded, SessionOptions());
  ASSERT_TRUE(session.ok());
  AdaptiveOptions options;
  options.arms = {"BruteForce"};
  auto adaptive = AdaptiveBroadPhase::Create(options, &(*session)->sink());
  EXPECT_EQ((*session)->Start(**adaptive).code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace sweepstake
