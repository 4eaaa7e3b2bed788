// Tests how switches are reported, lost and counted, and the effect of a changed object count.
#include <gtest/gtest.h>

#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

// Runs frames on the new arm in the next epoch without a report, as clients do until the arm has
// settled.
void ExecuteSilently(ScriptedClient& client, uint32_t arm) {
  client.arm = arm;
  ++client.epoch;
}

TEST(Switch, IsDetectedInTheFramesBeforeItIsReported) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.Settle();
  ASSERT_EQ(client.commands.size(), 1u);
  ExecuteSilently(client, 1);
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kHeldSettling);
  EXPECT_EQ(client.session.active_arm(), 1u);
  client.session.ObserveSwitch(1, client.epoch, SwitchReason::kPolicy, client.now_ns);
  EXPECT_TRUE(client.RunToTick().increment);  // the report did not restart the settling
  EXPECT_EQ(client.session.observation(client.now_ns).switch_count(SwitchReason::kPolicy), 1u);
}

TEST(Switch, ReportedAfterSettlingCountsFromItsFirstFrame) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.options.decision_interval_ns = 10 * kSecond;
  ScriptedClient client(setup);
  client.obedient = false;
  client.RunTicks(1);
  ASSERT_FALSE(client.commands.empty());
  const int64_t commanded_ns = client.now_ns;
  ExecuteSilently(client, 1);
  for (int i = 0; i < 201; ++i) client.RunFrame();
  client.session.ObserveSwitch(1, client.epoch, SwitchReason::kPolicy, client.now_ns);
  const ObservationSummary summary = client.session.observation(client.now_ns);
  EXPECT_EQ(summary.active_ns[0], static_cast<uint64_t>(commanded_ns + 10 * kMillisecond));
  EXPECT_EQ(summary.active_ns[1], 2'000'000'000u);
}

TEST(Switch, ReportedTwiceCountsOnce) {
  ScriptedClient client(PlainSetup(2));
  client.Execute(1, SwitchReason::kManual);
  client.session.ObserveSwitch(1, client.epoch, SwitchReason::kManual, client.now_ns + kSecond);
  EXPECT_EQ(client.session.observation(client.now_ns).switch_count(SwitchReason::kManual), 1u);
}

TEST(Switch, ReportedAfterTheNextOneDoesNotChangeTheActiveArm) {
  ScriptedClient client(PlainSetup(3));
  ExecuteSilently(client, 1);
  client.RunFrame();
  ExecuteSilently(client, 2);
  client.RunFrame();
  client.session.ObserveSwitch(1, 1, SwitchReason::kPolicy, client.now_ns);
  EXPECT_EQ(client.session.active_arm(), 2u);
  client.session.ObserveSwitch(2, 2, SwitchReason::kBailOut, client.now_ns);
  EXPECT_EQ(client.session.active_arm(), 2u);
  EXPECT_EQ(client.session.observation(client.now_ns).switch_count(SwitchReason::kBailOut), 1u);
}

TEST(Switch, TakesItsReasonFromTheReport) {
  ScriptedClient client(PlainSetup(2));
  client.Settle();
  ExecuteSilently(client, 1 - client.arm);
  client.RunFrame();
  client.session.ObserveSwitch(client.arm, client.epoch, SwitchReason::kManual, client.now_ns);
  const ObservationSummary summary = client.session.observation(client.now_ns);
  EXPECT_EQ(summary.switch_count(SwitchReason::kManual), 1u);
}

TEST(Command, IsNotRepeatedWhileASwitchMayBeInProgress) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.Settle();
  ASSERT_EQ(client.commands.size(), 1u);
  const Decision decision = client.RunToTick();
  EXPECT_EQ(decision.record.outcome, DecisionOutcome::kHeldSettling);
  EXPECT_TRUE(decision.increment);  // frames of the old arm are still learnt from
}

TEST(Command, WithoutAnAnswerIsRepeatedWithANewNumber) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.RunTicks(6);
  ASSERT_GE(client.commands.size(), 2u);
  EXPECT_EQ(client.commands[0].command_id, 1u);
  EXPECT_EQ(client.commands[1].command_id, 2u);
  EXPECT_EQ(client.commands[1].arm, 1u);
}

TEST(Command, HasTheSameTimeoutWithAnyTimeScale) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.options = setup.options.Scaled(100);  // a tick every 20 ms
  ScriptedClient client(setup);
  client.obedient = false;
  while (client.commands.empty()) client.RunToTick();
  const int64_t commanded_ns = client.now_ns;
  while (client.commands.size() < 2) client.RunToTick();
  EXPECT_GE(client.now_ns - commanded_ns, 4 * kSecond);
}

TEST(Command, ThatIsRefusedEndsAtOnce) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.Settle();
  ASSERT_EQ(client.commands.size(), 1u);
  client.session.ObserveRefusal(client.commands[0].command_id + 1);  // the id of another command
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kHeldSettling);
  client.session.ObserveRefusal(client.commands[0].command_id);
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kSwitched);
}

TEST(Command, IsNotRepeatedWithoutFrames) {
  ScriptedClient client(SetupThatWantsArmOne());
  client.obedient = false;
  client.Settle();
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(client.session.Tick(client.session.next_tick_ns()).command);
  }
}

TEST(ActiveTime, IsWallTimeBetweenActivationsSettlingAndStallsIncluded) {
  ScriptedClient client(PlainSetup(3));
  client.now_ns = 7 * kSecond;
  client.Execute(2, SwitchReason::kManual);
  client.now_ns = 30 * kSecond;
  client.Execute(1, SwitchReason::kManual);
  const ObservationSummary summary = client.session.observation(31 * kSecond);
  EXPECT_EQ(summary.active_ns,
            (std::vector<uint64_t>{7'000'000'000, 1'000'000'000, 23'000'000'000}));
}

TEST(PostExplorationSwitches, AreCountedByReasonAfterTheExploration) {
  SessionSetup setup = PlainSetup(4);
  setup.options.explore = true;
  ScriptedClient client(setup);
  client.RunTicks(30);
  ASSERT_FALSE(client.session.exploring());
  EXPECT_EQ(client.session.observation(client.now_ns).switch_counts, (std::array<uint64_t, 5>{}));
  client.Execute((client.arm + 1) % 4, SwitchReason::kBailOut);
  client.Execute((client.arm + 1) % 4, SwitchReason::kManual);
  client.Execute((client.arm + 1) % 4, SwitchReason::kManual);
  const ObservationSummary summary = client.session.observation(client.now_ns);
  EXPECT_EQ(summary.switch_count(SwitchReason::kBailOut), 1u);
  EXPECT_EQ(summary.switch_count(SwitchReason::kManual), 2u);
  EXPECT_EQ(summary.switch_count(SwitchReason::kExploration), 0u);
}

TEST(Epochs, WrapAround) {
  SessionSetup setup = PlainSetup(2);
  setup.switch_epoch = ~0u;
  ScriptedClient client(setup);
  client.obedient = false;
  client.Settle();
  ExecuteSilently(client, 1 - client.session.active_arm());
  ASSERT_EQ(client.epoch, 0u);
  client.RunToTick();
  EXPECT_EQ(client.session.active_arm(), client.arm);
}

TEST(ObjectCountChange, SettlesAgainAndKeepsThePosteriors) {
  ScriptedClient client(PlainSetup(1));
  client.RunTicks(3);
  const double evidence = client.session.posteriors()[0].evidence();
  const uint64_t settled = client.session.counts().settling_frame_count;
  client.frame.flags = kFrameRebuild;
  client.RunFrame();
  client.frame.flags = 0;
  EXPECT_EQ(client.RunToTick().record.outcome, DecisionOutcome::kHeldSettling);
  EXPECT_EQ(client.session.posteriors()[0].evidence(), evidence);
  EXPECT_TRUE(client.RunToTick().increment);
  EXPECT_EQ(client.session.counts().settling_frame_count - settled, 201u);
  EXPECT_EQ(client.session.counts().rebuild_frame_count, 1u);
  EXPECT_EQ(client.session.counts().rebuild_detection_time_ns, 1'667'000u);
}

TEST(ObjectCountChange, InEveryFramePreventsAtMostHalfOfTheLearning) {
  ScriptedClient client(PlainSetup(1));
  client.frame.flags = kFrameRebuild;
  client.RunTicks(101);
  const double windows = client.session.posteriors()[0].evidence() - 2;
  EXPECT_GE(windows, 48);
  EXPECT_GE(client.session.counts().measured_frame_count + 300,
            client.session.counts().settling_frame_count);
}

TEST(ObjectCountChange, DoesNotPreventTheCandidatesExecution) {
  SessionSetup setup = SetupThatWantsArmOne();
  setup.options.settling_ns = kSecond;  // half of the interval between ticks
  ScriptedClient client(setup);
  client.frame.flags = kFrameRebuild;
  client.RunTicks(4);
  EXPECT_FALSE(client.commands.empty());
}

TEST(ObjectCountChange, DoesNotSettleAgainWithinAnExplorationSlot) {
  SessionSetup setup = PlainSetup(1);
  setup.options.explore = true;
  ScriptedClient client(setup);
  client.RunTicks(2);
  for (int i = 0; i < 50; ++i) client.RunFrame();  // measures for longer than settling takes
  const uint64_t settled = client.session.counts().settling_frame_count;
  client.frame.flags = kFrameRebuild;
  client.RunFrame();
  EXPECT_EQ(client.session.counts().settling_frame_count, settled);
}

}  // namespace
}  // namespace sweepstake::decision
