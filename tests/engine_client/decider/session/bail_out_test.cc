// A frame over five seconds counts as ten observations of zero reward, and causes a new draw at
// once.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "engine_client/decider/session/run_phases.h"
#include "engine_client/decider/session/safeguards.h"
#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

FrameSample LongFrame(const ScriptedClient& client) {
  FrameSample frame = client.frame;
  frame.frame_time_ns = 5'100'000'000;
  frame.detection_time_ns = 5'000'000'000;
  frame.arm = client.arm;
  frame.switch_epoch = client.epoch;
  return frame;
}

SessionSetup SetupThatWantsArmOne() {
  SessionSetup setup = PlainSetup(2);
  setup.priors = {{1, 1e6}, {1e6, 1}};
  return setup;
}

TEST(BailOut, AddsTenZeroRewardObservationsToTheActiveArm) {
  ScriptedClient client(PlainSetup(2));
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  EXPECT_EQ(client.session.posteriors()[0], (BetaPosterior{1, 11}));
  EXPECT_EQ(client.session.posteriors()[1], (BetaPosterior{1, 1}));
  ASSERT_TRUE(decision.increment);
  EXPECT_EQ(decision.increment->beta, 10);
  EXPECT_EQ(decision.increment->alpha, 0);
  EXPECT_EQ(decision.increment->bail_out_count, 1u);
  EXPECT_EQ(decision.increment->window_count, 0u);
  EXPECT_EQ(client.session.counts().charged_bail_out_count, 1u);
}

TEST(BailOut, ResamplesAtOnceWithoutTheCooldown) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.Execute(0, SwitchReason::kManual);
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns + 1);
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kSwitched);
  EXPECT_EQ(decision.record.reason, SwitchReason::kBailOut);
  ASSERT_TRUE(decision.command);
  EXPECT_EQ(decision.command->arm, 1u);
  EXPECT_EQ(decision.command->reason, SwitchReason::kBailOut);
  EXPECT_EQ(decision.record.draws.size(), 2u);
}

TEST(BailOut, StaysIfTheDrawSelectsTheSameArm) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.active_arm = 1;
  ScriptedClient client(setup);
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kKept);
  EXPECT_EQ(decision.record.candidate, 1u);
  EXPECT_FALSE(decision.command);
}

// Makes long frames that detection does not explain: one with a short detection, one paused, one
// loading.
std::vector<FrameSample> ExcusableFrames(const ScriptedClient& client) {
  std::vector<FrameSample> frames(3, LongFrame(client));
  frames[0].detection_time_ns = frames[0].frame_time_ns / 2 - 1;
  frames[1].flags = kFramePaused;
  frames[2].flags = kFrameLoading;
  return frames;
}

TEST(BailOut, CountsForPolicyPaperWhateverItsCause) {
  ScriptedClient client(SetupThatWantsArmOne());
  for (const FrameSample& frame : ExcusableFrames(client)) {
    const Decision decision = client.session.ObserveBailOut(frame, client.now_ns);
    ASSERT_TRUE(decision.increment);
    EXPECT_EQ(decision.increment->beta, 10);
    ASSERT_TRUE(decision.command);
    EXPECT_EQ(decision.command->reason, SwitchReason::kBailOut);
    EXPECT_TRUE(client.session.IsEvidence(frame, client.now_ns));
  }
  EXPECT_EQ(client.session.counts().charged_bail_out_count, 3u);
}

// Policy `paper` blames the arm for every long frame, but nothing computed in a suspended frame.
TEST(BailOut, OfASuspendedFrameTeachesNoPolicyAnything) {
  for (const PolicyEntry& policy : ComparedPolicies()) {
    SessionSetup setup = SetupThatWantsArmOne();
    setup.options.policy = policy.kind.name;
    ScriptedClient client(setup);
    const std::vector<BetaPosterior> before(client.session.posteriors().begin(),
                                            client.session.posteriors().end());
    FrameSample frame = LongFrame(client);
    frame.flags = kFrameSuspended | kFrameBailOut;
    EXPECT_FALSE(client.session.IsEvidence(frame, client.now_ns)) << policy.kind.name;
    const Decision decision = client.session.ObserveBailOut(frame, client.now_ns);
    EXPECT_FALSE(decision.increment) << policy.kind.name;
    EXPECT_FALSE(decision.command) << policy.kind.name;
    client.session.ObserveFrames(std::vector{frame});
    EXPECT_TRUE(std::ranges::equal(client.session.posteriors(), before)) << policy.kind.name;
    EXPECT_EQ(client.session.counts().excused_bail_out_count, 1u) << policy.kind.name;
    EXPECT_EQ(client.session.counts().charged_bail_out_count, 0u) << policy.kind.name;
    EXPECT_EQ(client.session.counts().costless_frame_count, 1u) << policy.kind.name;
    EXPECT_EQ(client.session.counts().over_limit_frame_count, 0u) << policy.kind.name;
  }
}

TEST(BailOut, WithinTheLimitDoesNotCountForPolicyPaper) {
  ScriptedClient client(PlainSetup(2));
  FrameSample frame = LongFrame(client);
  frame.frame_time_ns = 5'000'000'000;
  EXPECT_FALSE(client.session.ObserveBailOut(frame, client.now_ns).increment);
}

TEST(BailOut, DoesNotCountForOtherPoliciesIfDetectionDoesNotExplainIt) {
  for (const PolicyEntry& policy : ComparedPolicies()) {
    if (policy.kind.name == "paper") continue;
    SessionSetup setup = PlainSetup(2);
    setup.options.policy = policy.kind.name;
    ScriptedClient client(setup);
    for (const FrameSample& frame : ExcusableFrames(client)) {
      const Decision decision = client.session.ObserveBailOut(frame, client.now_ns);
      EXPECT_FALSE(decision.increment) << policy.kind.name;
      EXPECT_FALSE(decision.command) << policy.kind.name;
      EXPECT_GT(decision.record.decision_id, 0u) << "it is logged nevertheless";
    }
    EXPECT_EQ(client.session.counts().excused_bail_out_count, 3u) << policy.kind.name;
  }
}

TEST(BailOut, IsJudgedByTheLimitOrTheClientsFlag) {
  EXPECT_FALSE(IsCausedByArm({.frame_time_ns = 100, .detection_time_ns = 90}, 100));
  EXPECT_TRUE(IsCausedByArm({.frame_time_ns = 101, .detection_time_ns = 90}, 100));
  EXPECT_TRUE(
      IsCausedByArm({.frame_time_ns = 50, .detection_time_ns = 25, .flags = kFrameBailOut}, 100));
  EXPECT_FALSE(
      IsCausedByArm({.frame_time_ns = 50, .detection_time_ns = 24, .flags = kFrameBailOut}, 100));
  const uint64_t huge = ~uint64_t{0};
  EXPECT_TRUE(IsCausedByArm({.frame_time_ns = huge, .detection_time_ns = huge}, 100));
  EXPECT_TRUE(IsCausedByArm({.frame_time_ns = 101, .detection_time_ns = huge}, 100));
}

TEST(BailOut, OverTheBudgetOfAGameIsAnsweredButIsNotEvidence) {
  ScriptedClient client(SetupThatWantsArmOne());
  const int64_t limit_ns = client.session.setup().options.bail_out_ns;
  for (int64_t i = 0; i < BailOutBudget::kBurst; ++i) {
    EXPECT_TRUE(client.session.ObserveBailOut(LongFrame(client), client.now_ns).increment);
  }
  const BetaPosterior before = client.session.posteriors()[0];
  const Decision surplus = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  EXPECT_FALSE(surplus.increment);
  EXPECT_EQ(surplus.command->arm, 1u);
  EXPECT_EQ(client.session.posteriors()[0].beta, before.beta + 10)
      << "its own session learns from it and leaves the arm";
  EXPECT_EQ(client.session.counts().surplus_bail_out_count, 1u);
  const int64_t later_ns = client.now_ns + limit_ns;
  EXPECT_FALSE(client.session.ObserveBailOut(LongFrame(client), later_ns - 1).increment);
  EXPECT_TRUE(client.session.ObserveBailOut(LongFrame(client), later_ns).increment);
  EXPECT_FALSE(client.session.ObserveBailOut(LongFrame(client), later_ns).increment);
}

TEST(BailOut, MarkedAsNoEvidenceIsAnsweredAndSpendsNoBudget) {
  ScriptedClient client(SetupThatWantsArmOne());
  FrameSample frame = LongFrame(client);
  frame.flags |= kFrameNoEvidence;
  const BetaPosterior before = client.session.posteriors()[0];
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(client.session.IsEvidence(frame, client.now_ns));
    const Decision decision = client.session.ObserveBailOut(frame, client.now_ns);
    EXPECT_FALSE(decision.increment);
    EXPECT_EQ(decision.command->arm, 1u);
  }
  EXPECT_EQ(client.session.posteriors()[0].beta, before.beta + 200);
  EXPECT_EQ(client.session.counts().surplus_bail_out_count, 20u);
}

TEST(BailOut, AtThePossibleMaximumRateIsAlwaysEvidence) {
  BailOutBudget budget(5, -100);
  for (int64_t now_ns = 0; now_ns < 5'000; now_ns += 5) EXPECT_TRUE(budget.Spend(now_ns));
}

TEST(BailOut, BudgetIsCorrectAtTheLimitsOfTheClock) {
  constexpr int64_t kEnd = std::numeric_limits<int64_t>::max();
  BailOutBudget budget(kMaxIntervalNs, -kEnd);
  for (const int64_t now_ns : {kEnd, -kEnd}) {
    EXPECT_EQ(budget.Spend(now_ns), now_ns == kEnd);
  }
}

TEST(BailOut, ExcludesItsFrameFromTheWindow) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  const FrameSample frame = LongFrame(client);
  client.session.ObserveFrames({&frame, 1});
  EXPECT_NEAR(*client.RunToTick().record.reward, 0.937, 1e-9);
  EXPECT_EQ(client.session.counts().over_limit_frame_count, 1u);
}

TEST(BailOut, TeachesNothingInManualMode) {
  SessionSetup setup = PlainSetup(2);
  setup.mode = Mode::kManual;
  ScriptedClient client(setup);
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kManual);
  EXPECT_FALSE(decision.increment);
  EXPECT_FALSE(decision.command);
}

TEST(BailOut, EndsTheSlotOfItsArmInTheExploration) {
  SessionSetup setup = PlainSetup(3);
  setup.options.explore = true;
  const std::vector<uint32_t> order = ExplorationOrder(setup.seed, 3);
  setup.active_arm = order[0];
  ScriptedClient client(setup);
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  EXPECT_EQ(client.session.explored_arm_count(), 1u);
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kExploring);
  ASSERT_TRUE(decision.command);
  EXPECT_EQ(decision.command->arm, order[1]);
  EXPECT_EQ(decision.command->reason, SwitchReason::kBailOut);
}

TEST(BailOut, InTheLastSlotOfTheExplorationIsFollowedByADraw) {
  SessionSetup setup = PlainSetup(2);
  setup.options.explore = true;
  const std::vector<uint32_t> order = ExplorationOrder(setup.seed, 2);
  setup.explored_arm_count = 1;
  setup.active_arm = order[1];
  setup.priors.assign(2, {1e6, 1});
  setup.priors[order[1]] = {1, 1e6};
  ScriptedClient client(setup);
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), 3 * kSecond);
  EXPECT_FALSE(client.session.exploring());
  ASSERT_TRUE(decision.command);
  EXPECT_EQ(decision.command->arm, order[0]);
  EXPECT_EQ(client.session.observation(3 * kSecond).start_ns, 3 * kSecond);
}

TEST(BailOut, OfAnEarlierEpochCountsForItsArmWithoutACommand) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.active_arm = 1;
  ScriptedClient client(setup);
  const FrameSample late = LongFrame(client);
  client.Execute(0, SwitchReason::kBailOut);  // a draw would select arm 1 again
  const Decision decision = client.session.ObserveBailOut(late, client.now_ns);
  ASSERT_TRUE(decision.increment);
  EXPECT_EQ(decision.increment->arm, 1u);
  EXPECT_FALSE(decision.record.candidate);
  EXPECT_FALSE(decision.command);
}

TEST(BailOut, OfALaterEpochImpliesThatTheSwitchWasExecuted) {
  ScriptedClient client(PlainSetup(2));
  FrameSample frame = LongFrame(client);
  frame.arm = 1;
  frame.switch_epoch = 1;
  const Decision decision = client.session.ObserveBailOut(frame, kSecond);
  EXPECT_EQ(decision.record.active_arm, 1u);
  EXPECT_EQ(decision.increment->arm, 1u);
}

TEST(BailOut, OfAnUnknownArmChangesNothing) {
  ScriptedClient client(PlainSetup(2));
  FrameSample frame = LongFrame(client);
  frame.arm = 77;
  EXPECT_FALSE(client.session.ObserveBailOut(frame, client.now_ns).increment);
}

TEST(BailOut, RestartsTheCooldownWhenItsSwitchIsExecuted) {
  ScriptedClient client(SetupThatWantsArmOne());
  const Decision decision = client.session.ObserveBailOut(LongFrame(client), client.now_ns);
  client.Execute(decision.command->arm, SwitchReason::kBailOut);
  client.Execute(0, SwitchReason::kBailOut);
  client.RunTicks(19);
  EXPECT_TRUE(client.commands.empty());
  client.RunTicks(1);
  EXPECT_EQ(client.commands.size(), 1u);
}

}  // namespace
}  // namespace sweepstake::decision
