// Tests the rules of a decision on a scripted clock: window, update, choice, cooldown, settling,
// modes. exploration_test.cc and bail_out_test.cc test exploration and bail-outs; reward_test.cc
// tests scores and weights.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/decider/policy/reward.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

TEST(Arms, AreTheNamesTheClientAnnounced) {
  SessionSetup setup = PlainSetup(3);
  setup.arms = {"KDTree", "a game's own arm", "SAP"};
  EXPECT_EQ(DecisionSession(setup, ShippedPolicies()).arms(), setup.arms);
}

TEST(Priors, AreBetaOneOneByDefault) {
  DecisionSession fresh(PlainSetup(2), ShippedPolicies());
  EXPECT_EQ(fresh.posteriors()[1], (BetaPosterior{1, 1}));
  EXPECT_EQ(fresh.posteriors()[1].evidence(), 2);  // n includes the prior
  DecisionSession loaded(SetupThatWantsArmOne(), ShippedPolicies());
  EXPECT_EQ(loaded.posteriors()[1], (BetaPosterior{1e6, 1}));
}

TEST(Window, HoldsAllFramesSinceTheLastTick) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  client.RunToTick();
  // The FPS score is 1 at 100 FPS and 0 at 50 FPS. The next window has 150 frames in 2 s,
  // independent of earlier frames.
  for (int i = 0; i < 100; ++i) client.RunFrame();
  client.frame.frame_time_ns = 20'000'000;
  const Decision decision = client.RunToTick();
  EXPECT_NEAR(*decision.record.reward, 0.55 * 0.5 + 0.25 * 0.9 + 0.12 * 0.75 + 0.08 * 0.9, 0.01);
}

// With only its own frame rates as reference, arm 1 would score 1 at 50 FPS.
TEST(Window, AfterASwitchIsScoredAgainstEarlierFrameRatesToo) {
  ScriptedClient client(PlainSetup(2));
  client.obedient = false;
  client.Settle();
  client.RunTicks(3);
  client.Execute(1, SwitchReason::kManual);
  client.frame.frame_time_ns = 20'000'000;
  client.Settle();
  // The frames of arm 0 still set the range: the FPS score is 1 at 100 FPS and 0 at 50 FPS.
  const double without_fps = 0.25 * 0.9 + 0.12 * 0.75 + 0.08 * 0.9;
  EXPECT_NEAR(*client.RunToTick().record.reward, without_fps, 0.01);
  client.RunTicks(FpsReference::kWindowCount);
  EXPECT_NEAR(*client.RunToTick().record.reward, 0.55 + without_fps, 0.01)
      << "the range no longer contains windows of arm 0";
}

TEST(Window, WithoutFramesTeachesNothing) {
  ScriptedClient client(PlainSetup(2));
  client.Settle();
  const BetaPosterior before = client.session.posteriors()[client.arm];
  const Decision decision = client.session.Tick(client.session.next_tick_ns());
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kNoFrames);
  EXPECT_FALSE(decision.increment);
  EXPECT_FALSE(decision.record.reward);
  EXPECT_FALSE(decision.command);
  EXPECT_EQ(client.session.posteriors()[client.arm], before);
}

TEST(Window, OmitsFramesWithoutCost) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  for (const uint32_t flag : {kFramePaused, kFrameLoading, kFrameSuspended, kFramePairsExceeded}) {
    client.frame.flags = flag;
    EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kNoFrames);
  }
  EXPECT_EQ(client.session.counts().costless_frame_count, 800u);
}

// The game shows a menu without searches, and does not mark its frames as paused.
TEST(Window, WithoutASearchTeachesNothing) {
  SessionSetup setup = PlainSetup(1);
  setup.options.policy = "adaptive";
  ScriptedClient client(setup);
  client.Settle();
  client.RunToTick();
  const BetaPosterior before = client.session.posteriors()[0];
  client.frame.detection_time_ns = 0;
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kNoFrames);
  EXPECT_EQ(client.session.posteriors()[0], before);
}

TEST(Window, OmitsFramesOfAnEarlierEpoch) {
  ScriptedClient client(PlainSetup(2));
  client.obedient = false;
  client.Settle();
  client.Execute(1 - client.arm, SwitchReason::kManual);
  FrameSample old = client.frame;
  old.arm = 1 - client.arm;
  old.switch_epoch = client.epoch - 1;
  client.session.ObserveFrames(std::vector<FrameSample>(5, old));
  old.switch_epoch = client.epoch;  // an arm that does not run in this epoch
  client.session.ObserveFrames(std::vector<FrameSample>(3, old));
  old.arm = 99;
  client.session.ObserveFrames(std::vector<FrameSample>(2, old));
  EXPECT_EQ(client.session.counts().other_epoch_frame_count, 10u);
  EXPECT_EQ(client.session.Tick(client.session.next_tick_ns()).record.outcome,
            DecisionOutcome::kNoFrames);
}

TEST(Update, AddsTheRewardToAlphaAndItsComplementToBetaOfTheActiveArmOnly) {
  SessionSetup setup = PlainSetup(3);
  setup.active_arm = 1;
  ScriptedClient client(setup);
  client.obedient = false;
  client.RunToTick();
  const Decision decision = client.RunToTick();
  // The scores are 1 for FPS, 0.9 for detection, 0.75 for memory and 0.9 for checks.
  EXPECT_NEAR(*decision.record.reward, 0.937, 1e-12);
  const auto after = client.session.posteriors();
  EXPECT_EQ(after[0], (BetaPosterior{1, 1}));
  EXPECT_EQ(after[2], (BetaPosterior{1, 1}));
  EXPECT_DOUBLE_EQ(after[1].alpha, 1 + *decision.record.reward);
  EXPECT_DOUBLE_EQ(after[1].beta, 2 - *decision.record.reward);
  EXPECT_EQ(decision.increment->arm, 1u);
  EXPECT_EQ(decision.increment->window_count, 1u);
  EXPECT_EQ(decision.increment->bail_out_count, 0u);
}

TEST(Standings, OfThePaperCountWindowsAndHaveNoCosts) {
  ScriptedClient client(PlainSetup(2));
  client.obedient = false;
  EXPECT_EQ(client.session.standings()[0].effective_window_count, 0);
  client.Settle();
  const ShadowSample visit{.detection_time_ns = 1000, .arm = 1};
  client.session.ObserveShadow({&visit, 1});
  const uint64_t before = client.session.standings()[0].live_window_count;
  const Decision decision = client.RunTicks(3);
  ASSERT_EQ(decision.record.standings.size(), 2u);
  const ArmStanding& active = decision.record.standings[0];
  EXPECT_EQ(active.live_window_count, before + 3);
  EXPECT_NEAR(active.effective_window_count, static_cast<double>(before + 3), 1e-9);
  EXPECT_FALSE(active.cost_ratio);
  const ArmStanding& other = decision.record.standings[1];
  EXPECT_EQ(other.live_window_count, 0u);
  EXPECT_EQ(other.lane_visit_count, 0u) << "the policy does not learn from visits";
  EXPECT_EQ(other.effective_window_count, 0);
}

TEST(Update, RejectsAWindowWithAMetricThatIsNotFinite) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.Settle();
  const std::vector<BetaPosterior> before(client.session.posteriors().begin(),
                                          client.session.posteriors().end());
  FrameSample instant = client.frame;
  instant.frame_time_ns = 0;
  client.session.ObserveFrames(std::vector<FrameSample>(100, instant));
  const Decision decision = client.session.Tick(client.session.next_tick_ns());
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kRejected);
  EXPECT_FALSE(decision.increment);
  EXPECT_FALSE(decision.command);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), client.session.posteriors().begin()));
}

TEST(Update, AbsurdFramesGiveARewardInTheUnitInterval) {
  for (const uint64_t time : {uint64_t{1}, uint64_t{4'999'999'999}}) {
    for (const uint64_t value : {uint64_t{0}, std::numeric_limits<uint64_t>::max()}) {
      for (const uint32_t objects : {0u, 1u, 2u, ~0u}) {
        SessionSetup setup = PlainSetup(1);
        setup.options.settling_ns = 0;
        DecisionSession session(setup, ShippedPolicies());
        const FrameSample frame{.frame_time_ns = time,
                                .detection_time_ns = value,
                                .aabb_check_count = value,
                                .native_bytes = value,
                                .object_count = objects};
        session.ObserveFrames({&frame, 1});
        const Decision decision = session.Tick(session.next_tick_ns());
        ASSERT_TRUE(decision.record.reward);
        EXPECT_GE(*decision.record.reward, 0);
        EXPECT_LE(*decision.record.reward, 1);
      }
    }
  }
}

TEST(Choice, DrawsOncePerArmAtEveryTickAndTheHighestIsTheCandidate) {
  ScriptedClient client(PlainSetup(5));
  client.RunTicks(100);
  for (const Decision& decision : client.log) {
    const std::vector<double>& draws = decision.record.draws;
    ASSERT_EQ(draws.size(), 5u);
    const auto highest = std::max_element(draws.begin(), draws.end()) - draws.begin();
    EXPECT_EQ(decision.record.candidate, static_cast<uint32_t>(highest));
  }
}

TEST(Choice, DependsOnlyOnTheSeed) {
  const auto candidates = [](uint64_t seed) {
    SessionSetup setup = PlainSetup(7);
    setup.seed = seed;
    ScriptedClient client(setup);
    client.RunTicks(50);
    std::vector<std::vector<double>> draws;
    for (const Decision& decision : client.log) draws.push_back(decision.record.draws);
    return draws;
  };
  EXPECT_EQ(candidates(3), candidates(3));
  EXPECT_NE(candidates(3), candidates(4));
}

TEST(OrderAtATick, IsUpdateThenSampleThenGate) {
  ScriptedClient client(PlainSetup(3));
  client.RunTicks(60);
  for (const Decision& decision : client.log) {
    const DecisionRecord& record = decision.record;
    for (uint32_t arm = 0; arm < 3; ++arm) {
      // The draw is from the posterior that already contains this tick's window.
      RandomStream stream(1, RandomPurpose::kChoice, record.decision_id, arm);
      EXPECT_EQ(record.draws[arm], DrawBeta(record.posteriors[arm], stream));
    }
    if (decision.command) {
      EXPECT_EQ(decision.command->arm, record.candidate);
    }
  }
  EXPECT_FALSE(client.commands.empty());
}

TEST(Cooldown, DelaysACandidateForFortySecondsAfterAnExecutedSwitch) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.Settle();
  client.Execute(0, SwitchReason::kManual);
  const int64_t switched_ns = client.now_ns;
  while (client.commands.size() < 2) {  // the first switch was at the start, without a cooldown
    const Decision decision = client.RunToTick();
    ASSERT_LE(client.now_ns - switched_ns, 41 * kSecond);
    if (decision.command) {
      EXPECT_GE(client.now_ns - switched_ns, 40 * kSecond);
      EXPECT_EQ(decision.record.outcome, DecisionOutcome::kSwitched);
      EXPECT_EQ(decision.record.reason, SwitchReason::kPolicy);
    }
  }
}

TEST(Cooldown, LogsADelayedCandidateAndDoesNotQueueIt) {
  // Arm 1 is the candidate for some ticks, but at the end of the cooldown arm 0 is better.
  SessionSetup setup = PlainSetup(2);
  setup.priors = {{1, 20}, {200, 200}};
  setup.options.cooldown_ns = 2'000 * kSecond;
  ScriptedClient client(setup);
  client.Execute(0, SwitchReason::kManual);
  client.RunTicks(3);
  EXPECT_EQ(client.log.back().record.outcome, DecisionOutcome::kHeldCooldown);
  EXPECT_EQ(client.log.back().record.candidate, 1u);
  client.RunTicks(1'100);
  EXPECT_EQ(client.log.back().record.outcome, DecisionOutcome::kKept);
  EXPECT_TRUE(client.commands.empty());
}

TEST(Cooldown, DoesNotDelayTheFirstSwitchOfANewSession) {
  ScriptedClient client(SetupThatWantsArmOne());
  EXPECT_EQ(client.RunTicks(2).record.outcome, DecisionOutcome::kSwitched);
}

TEST(Cooldown, CountsFromTheStartIfASessionContinuesAfterARestart) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.decision_count = 17;
  ScriptedClient client(setup);
  client.RunTicks(19);
  EXPECT_TRUE(client.commands.empty());
  client.RunTicks(1);
  ASSERT_EQ(client.commands.size(), 1u);
  EXPECT_GT(client.commands[0].command_id, 17u);
  EXPECT_EQ(client.log[0].record.decision_id, 18u);
}

TEST(Settling, OmitsTwoSecondsOfFrameTimeAfterTheFirstFrame) {
  ScriptedClient client(PlainSetup(1));
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kHeldSettling);
  EXPECT_FALSE(client.log.back().increment);
  EXPECT_TRUE(client.RunToTick().increment);
  EXPECT_EQ(client.session.counts().settling_frame_count,
            201u);  // the first frame, and two seconds of further frames
}

TEST(Settling, RestartsTheWindowAtASwitch) {
  ScriptedClient client(PlainSetup(2));
  client.obedient = false;
  client.Settle();
  for (int i = 0; i < 50; ++i) client.RunFrame();  // good frames of the old arm
  client.Execute(1 - client.arm, SwitchReason::kManual);
  const Decision decision = client.RunToTick();
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kHeldSettling);
  EXPECT_FALSE(decision.increment);
}

TEST(Settling, RunsOnFrameTimeNotOnTheTicksClock) {
  ScriptedClient client(PlainSetup(1));
  client.RunFrame();
  for (int i = 0; i < 10; ++i)
    client.session.Tick(client.session.next_tick_ns());  // 20 s without frames
  client.now_ns = client.session.next_tick_ns() - kSecond;
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kHeldSettling);
}

TEST(Ticks, HappenEveryTwoSeconds) {
  SessionSetup setup = PlainSetup(1);
  setup.start_ns = -5 * kSecond;
  DecisionSession session(setup, ShippedPolicies());
  EXPECT_EQ(session.next_tick_ns(), -3 * kSecond);
  session.Tick(-3 * kSecond);
  EXPECT_EQ(session.next_tick_ns(), -1 * kSecond);
  session.Tick(-1 * kSecond + 7);  // a late tick does not delay the next one
  EXPECT_EQ(session.next_tick_ns(), kSecond);
}

TEST(LateTick, IsOneTickWithOneUpdateNeverSeveral) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  const double evidence = client.session.posteriors()[0].evidence();
  client.frame.frame_time_ns = 4'900'000'000;  // longer than the interval
  const Decision decision = client.RunToTick();
  EXPECT_NEAR(client.session.posteriors()[0].evidence(), evidence + 1, 1e-12);
  EXPECT_TRUE(decision.increment);
  EXPECT_GT(client.session.next_tick_ns(), client.now_ns);
  EXPECT_EQ(client.session.next_tick_ns(), client.now_ns + 2 * kSecond);
}

TEST(LateTick, AtTheEndOfTimeDoesNotOverflow) {
  SessionSetup setup = PlainSetup(2);
  setup.start_ns = std::numeric_limits<int64_t>::min();
  DecisionSession session(setup, ShippedPolicies());
  session.ObserveSwitch(1, 1, SwitchReason::kManual, setup.start_ns);
  session.Tick(std::numeric_limits<int64_t>::max());
  EXPECT_EQ(session.next_tick_ns(), std::numeric_limits<int64_t>::max());
  session.Tick(std::numeric_limits<int64_t>::max());
}

TEST(ManualMode, RecordsEverythingAndLearnsNothing) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.mode = Mode::kManual;
  ScriptedClient client(setup);
  client.RunTicks(30);
  EXPECT_TRUE(client.commands.empty());
  EXPECT_EQ(client.session.posteriors()[0], setup.priors[0]);
  EXPECT_EQ(client.session.counts().measured_frame_count, 5'799u);
  for (const Decision& decision : client.log) {
    EXPECT_EQ(decision.record.outcome, DecisionOutcome::kManual);
    EXPECT_FALSE(decision.increment);
    EXPECT_FALSE(decision.record.candidate);
  }
}

TEST(ManualMode, LeavesNoFramesForTheModeThatFollows) {
  SessionSetup setup = PlainSetup(2);
  setup.mode = Mode::kManual;
  ScriptedClient client(setup);
  client.Settle();
  for (int i = 0; i < 50; ++i) client.RunFrame();
  client.session.SetMode(Mode::kAi, 0, client.now_ns);
  EXPECT_EQ(client.session.mode(), Mode::kAi);
  EXPECT_EQ(client.session.Tick(client.session.next_tick_ns()).record.outcome,
            DecisionOutcome::kNoFrames);
}

TEST(ModeChange, SetsTheArmThatIsActiveThen) {
  ScriptedClient client(PlainSetup(3));
  client.session.SetMode(Mode::kManual, 2, client.now_ns);
  EXPECT_EQ(client.session.active_arm(), 2u);
}

TEST(Decisions, AreNumberedConsecutivelyWhateverTheirOutcome) {
  ScriptedClient client(PlainSetup(2));
  client.RunTicks(5);
  client.session.ObserveBailOut(client.frame, client.now_ns);
  client.session.SetMode(Mode::kManual, client.arm, client.now_ns);
  EXPECT_EQ(client.RunToTick().record.decision_id, 7u);
  EXPECT_EQ(client.session.decision_count(), 7u);
}

}  // namespace
}  // namespace sweepstake::decision
