#include "sweepstake/adaptive_broad_phase.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine_client/adaptive/adaptive_factory.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::RecordingSink;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;
using ::testing::HasSubstr;

constexpr uint64_t kSecond = 1'000'000'000;

// Runs an AdaptiveBroadPhase on the scripted arms A, B and C.
class AdaptiveBroadPhaseTest : public ::testing::Test {
 protected:
  void SetUp() override { Make({}); }

  void Make(const AdaptiveOptions& options) {
    std::vector<std::unique_ptr<BroadPhase>> backends;
    arms_.clear();
    for (const char* name : {"A", "B", "C"}) {
      const ArmScript script{.name = name,
                             .version = static_cast<uint32_t>(arms_.size() + 1),
                             .build_ns = 1000,
                             .update_ns = 100,
                             .find_ns = 10,
                             .check_count = 5,
                             .bytes = 64 * (arms_.size() + 1),
                             .pair_count = 3};
      auto backend = std::make_unique<ScriptedBroadPhase>(script, clock_);
      arms_.push_back(backend.get());
      backends.push_back(std::move(backend));
    }
    sink_ = RecordingSink();
    adaptive_ = std::move(*AdaptiveFactory::Make(options, std::move(backends), &sink_, clock_));
  }

  // Runs one frame of `frame_time_ns` with `count` objects.
  const FrameSample& Frame(uint64_t frame_time_ns = kSecond / 60, size_t count = 4,
                           uint32_t flags = 0) {
    const std::vector<Aabb> boxes(count);
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes);
    adaptive_->EndFrame({.frame_time_ns = frame_time_ns, .flags = flags});
    return adaptive_->last_sample();
  }

  // Runs a frame that exceeds the bail-out limit because of the active arm's detection.
  void BailOut(uint32_t flags = 0) {
    ArmScript& script = arms_[adaptive_->active_arm()]->script();
    const uint64_t ordinary = std::exchange(script.find_ns, 6 * kSecond);
    Frame(7 * kSecond, 4, flags);
    script.find_ns = ordinary;
  }

  ScriptedClock clock_;
  RecordingSink sink_;
  std::vector<ScriptedBroadPhase*> arms_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(AdaptiveBroadPhaseTest, BuildsInTheFirstFrameAndUpdatesInTheNext) {
  EXPECT_EQ(Frame().flags, uint32_t{kFrameRebuild});
  EXPECT_EQ(Frame().flags, 0U);
  EXPECT_EQ(arms_[0]->build_count, 1);
  EXPECT_EQ(arms_[0]->update_count, 1);
}

TEST_F(AdaptiveBroadPhaseTest, MeasuresUpdateAndSearchWithTheInjectedClock) {
  EXPECT_EQ(Frame().detection_time_ns, 1010U);
  const FrameSample& sample = Frame(123);
  EXPECT_EQ(sample.detection_time_ns, 110U);
  EXPECT_EQ(sample.frame_time_ns, 123U);
  EXPECT_EQ(sample.aabb_check_count, 5U);
  EXPECT_EQ(sample.native_bytes, 64U);
  EXPECT_EQ(sample.pair_count, 3U);
  EXPECT_EQ(sample.object_count, 4U);
}

TEST_F(AdaptiveBroadPhaseTest, NumbersFramesWithoutGapsAndPassesEachToTheSink) {
  for (int i = 0; i < 5; ++i) Frame();
  ASSERT_EQ(sink_.frames.size(), 5U);
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(sink_.frames[i].frame_index, i);
}

TEST_F(AdaptiveBroadPhaseTest, DoesNotRebuildWhenTheObjectCountChanges) {
  Frame(1, 4);
  EXPECT_EQ(Frame(1, 5).flags, 0U);
  EXPECT_EQ(Frame(1, 0).flags, 0U);
  EXPECT_EQ(arms_[0]->build_count, 1);
}

TEST_F(AdaptiveBroadPhaseTest, ReturnsThePairsOfTheActiveArm) {
  const std::vector<Aabb> boxes(4);
  adaptive_->BeginFrame();
  EXPECT_EQ(adaptive_->FindPairs(boxes).size(), 3U);
  adaptive_->EndFrame({});
}

TEST_F(AdaptiveBroadPhaseTest, ExecutesACommandOnlyAtTheStartOfAFrame) {
  const std::vector<Aabb> boxes(4);
  adaptive_->BeginFrame();
  adaptive_->mailbox().Post({.command_id = 9, .arm = 2});
  adaptive_->FindPairs(boxes);
  adaptive_->EndFrame({});
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  const FrameSample& sample = Frame();
  EXPECT_EQ(sample.arm, 2U);
  EXPECT_EQ(sample.switch_epoch, 1U);
  EXPECT_EQ(sample.flags, uint32_t{kFrameRebuild});
  EXPECT_EQ(sample.native_bytes, 192U);
  EXPECT_EQ(arms_[2]->build_count, 1);
}

TEST_F(AdaptiveBroadPhaseTest, BuildsAgainAfterReturningToAnArm) {
  Frame();
  adaptive_->mailbox().Post({.command_id = 1, .arm = 1});
  Frame();
  adaptive_->mailbox().Post({.command_id = 2, .arm = 0});
  EXPECT_EQ(Frame().flags, uint32_t{kFrameRebuild});
  EXPECT_EQ(arms_[0]->build_count, 2);
}

TEST_F(AdaptiveBroadPhaseTest, ReadsNoClockAndKeepsItsArmWhileFrozen) {
  Frame();
  const uint64_t read_count = clock_.reading_count();
  EXPECT_GT(read_count, 0U);
  EXPECT_TRUE(adaptive_->Obey({.order_id = 3, .mode = Mode::kAi, .arm = 1}))
      << "an order waits for the next frame";
  adaptive_->Freeze();
  EXPECT_EQ(adaptive_->mode(), Mode::kManual);
  adaptive_->mailbox().Post({.command_id = 1, .arm = 2, .reason = SwitchReason::kManual});
  EXPECT_FALSE(adaptive_->Obey({.order_id = 4, .mode = Mode::kAi, .arm = 2}));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Frame().detection_time_ns, 0U);
  BailOut();
  EXPECT_EQ(Frame().arm, 0U);
  ASSERT_EQ(sink_.mode_changes.size(), 1U) << "Freeze reports kManual, and no order is executed";
  EXPECT_EQ(sink_.mode_changes[0].mode, Mode::kManual);
  EXPECT_EQ(sink_.mode_changes[0].order_id, 0U);
  ASSERT_TRUE(adaptive_->SelectArm("B").ok());
  EXPECT_EQ(Frame().arm, 1U) << "the game itself may choose";
  EXPECT_EQ(clock_.reading_count(), read_count);

  adaptive_->SetMode(Mode::kAi);
  adaptive_->mailbox().Post({.command_id = 2, .arm = 2});
  EXPECT_GT(Frame().detection_time_ns, 0U);
  EXPECT_EQ(adaptive_->active_arm(), 2U);
}

TEST_F(AdaptiveBroadPhaseTest, IgnoresABailOutBeforeAFreeze) {
  Frame();
  BailOut();
  adaptive_->Freeze();
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, ReportsASwitchAndItsCostAfterSettling) {
  AdaptiveOptions options;
  options.settling_ns = 100;
  Make(options);
  Frame();
  adaptive_->mailbox().Post({.command_id = 9, .arm = 1, .reason = SwitchReason::kExploration});
  Frame(50);
  EXPECT_TRUE(sink_.switches.empty());
  Frame(30);
  Frame(30);
  ASSERT_EQ(sink_.switches.size(), 1U);
  const SwitchOutcome& outcome = sink_.switches[0];
  EXPECT_EQ(outcome.command_id, 9U);
  EXPECT_EQ(outcome.arm, 1U);
  EXPECT_EQ(outcome.switch_epoch, 1U);
  EXPECT_EQ(outcome.rebuild_time_ns, 1000U);
  EXPECT_EQ(outcome.settling_cost_ns, 20U);
  EXPECT_EQ(outcome.reason, SwitchReason::kExploration);
  EXPECT_EQ(outcome.executed, 1U);
}

TEST_F(AdaptiveBroadPhaseTest, RefusesCommandsForTheActiveOrAnUnknownArm) {
  for (const uint32_t arm : {0U, 3U, 1000U}) {
    adaptive_->mailbox().Post({.command_id = 5, .arm = arm});
    Frame();
    ASSERT_FALSE(sink_.switches.empty());
    EXPECT_EQ(sink_.switches.back().executed, 0U);
    EXPECT_EQ(sink_.switches.back().command_id, 5U);
    EXPECT_EQ(sink_.switches.back().arm, 0U);
  }
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
}

TEST_F(AdaptiveBroadPhaseTest, RefusesCommandsOfThePolicyInManualMode) {
  adaptive_->SetMode(Mode::kManual);
  for (const auto reason :
       {SwitchReason::kPolicy, SwitchReason::kExploration, SwitchReason::kBailOut}) {
    adaptive_->mailbox().Post({.command_id = 1, .arm = 1, .reason = reason});
    Frame();
    EXPECT_EQ(sink_.switches.back().executed, 0U);
  }
  adaptive_->mailbox().Post({.command_id = 1, .arm = 1, .reason = SwitchReason::kManual});
  Frame();
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(AdaptiveBroadPhaseTest, KeepsTheLatestOutcomeAlsoWithoutASink) {
  auto backend = std::make_unique<ScriptedBroadPhase>(ArmScript{.name = "A"}, clock_);
  std::vector<std::unique_ptr<BroadPhase>> backends;
  backends.push_back(std::move(backend));
  adaptive_ = std::move(*AdaptiveFactory::Make({}, std::move(backends), nullptr, clock_));
  EXPECT_FALSE(adaptive_->last_outcome());
  adaptive_->mailbox().Post({.command_id = 5, .arm = 1, .reason = SwitchReason::kExploration});
  Frame();
  ASSERT_TRUE(adaptive_->last_outcome());
  EXPECT_EQ(adaptive_->last_outcome()->command_id, 5U);
  EXPECT_EQ(adaptive_->last_outcome()->reason, SwitchReason::kExploration);
  EXPECT_EQ(adaptive_->last_outcome()->executed, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, ReturnsTheLatestDecisionOfTheDecider) {
  EXPECT_FALSE(adaptive_->last_decision());
  LastDecision decision{.decision_id = 3, .candidate_arm = 2, .arm_count = 3};
  decision.best_probability[2] = 0.75;
  adaptive_->SetLastDecision(decision);
  ASSERT_TRUE(adaptive_->last_decision());
  EXPECT_EQ(adaptive_->last_decision()->decision_id, 3U);
  EXPECT_EQ(adaptive_->last_decision()->candidate_arm, 2U);
  EXPECT_FALSE(adaptive_->last_decision()->command);
  EXPECT_EQ(adaptive_->last_decision()->best_probability[2], 0.75);
}

TEST_F(AdaptiveBroadPhaseTest, SelectsAnArmByNameForTheNextFrame) {
  ASSERT_TRUE(adaptive_->SelectArm("C").ok());
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  EXPECT_EQ(Frame().arm, 2U);
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
}

TEST_F(AdaptiveBroadPhaseTest, SelectingAnUnknownArmListsTheValidOnes) {
  const Status status = adaptive_->SelectArm("D");
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("A, B, C"));
}

TEST_F(AdaptiveBroadPhaseTest, AManualSelectionOverridesACommandOfTheSameFrame) {
  ASSERT_TRUE(adaptive_->SelectArm("C").ok());
  adaptive_->mailbox().Post({.command_id = 4, .arm = 1});
  EXPECT_EQ(Frame().arm, 2U);
  ASSERT_EQ(sink_.switches.size(), 1U);
  EXPECT_EQ(sink_.switches[0].command_id, 4U);
  EXPECT_EQ(sink_.switches[0].executed, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, KeepsAnOrderedArmAndReportsItInTheSameFrame) {
  adaptive_->Obey({.order_id = 9, .mode = Mode::kManual, .arm = 2});
  adaptive_->mailbox().Post({.command_id = 4, .arm = 1});
  EXPECT_EQ(Frame().arm, 2U);
  ASSERT_EQ(sink_.mode_changes.size(), 1U);
  EXPECT_EQ(sink_.mode_changes[0].order_id, 9U);
  EXPECT_EQ(sink_.mode_changes[0].mode, Mode::kManual);
  EXPECT_EQ(sink_.mode_changes[0].active_arm, 2U);
  EXPECT_EQ(sink_.switches.at(0).executed, 0U) << "the command of the policy is refused";
  adaptive_->mailbox().Post({.command_id = 5, .arm = 1});
  EXPECT_EQ(Frame().arm, 2U);
  adaptive_->Obey({.order_id = 10, .mode = Mode::kAi, .arm = {}});
  adaptive_->mailbox().Post({.command_id = 6, .arm = 1});
  EXPECT_EQ(Frame().arm, 1U);
  EXPECT_EQ(sink_.mode_changes.at(1).order_id, 10U);
}

TEST_F(AdaptiveBroadPhaseTest, ConfirmsAnOrderThatChangesNothing) {
  adaptive_->Obey({.order_id = 1, .mode = Mode::kManual, .arm = 0});
  Frame();
  adaptive_->Obey({.order_id = 2, .mode = Mode::kManual, .arm = {}});
  Frame();
  EXPECT_EQ(sink_.mode_changes.size(), 2U);
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
  EXPECT_EQ(adaptive_->mode(), Mode::kManual);
}

TEST_F(AdaptiveBroadPhaseTest, ABailOutEndsTheModeOfAnOrderAndSwitches) {
  adaptive_->Obey({.order_id = 1, .mode = Mode::kManual, .arm = 1});
  Frame();
  Frame(7 * kSecond);
  EXPECT_EQ(adaptive_->mode(), Mode::kManual) << "the arm did not cause the long frame";
  BailOut();
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
  ASSERT_EQ(sink_.mode_changes.size(), 2U);
  EXPECT_EQ(sink_.mode_changes[1].mode, Mode::kAi);
  EXPECT_EQ(sink_.mode_changes[1].order_id, 0U);
  EXPECT_EQ(Frame().arm, 2U);
}

TEST_F(AdaptiveBroadPhaseTest, ABailOutKeepsTheManualModeOfTheGame) {
  adaptive_->SetMode(Mode::kManual);
  adaptive_->Obey({.order_id = 1, .mode = Mode::kManual, .arm = 1});
  Frame();
  BailOut();
  EXPECT_EQ(Frame().arm, 1U);
  adaptive_->Obey({.order_id = 2, .mode = Mode::kAi, .arm = {}});
  Frame();
  adaptive_->Obey({.order_id = 3, .mode = Mode::kManual, .arm = {}});
  Frame();
  adaptive_->SetMode(Mode::kManual);
  BailOut();
  EXPECT_EQ(adaptive_->mode(), Mode::kManual) << "the game has chosen the mode since then";
}

TEST_F(AdaptiveBroadPhaseTest, FlagsAFrameOverTheLimitAndSwitchesInTheNext) {
  BailOut();
  EXPECT_NE(sink_.frames.back().flags & kFrameBailOut, 0U);
  EXPECT_EQ(sink_.frames.back().arm, 0U);
  EXPECT_EQ(Frame().arm, 1U);
  EXPECT_EQ(Frame().arm, 1U);
}

TEST_F(AdaptiveBroadPhaseTest, ABailOutSwitchesToTheHighestPosteriorMean) {
  adaptive_->SetPosteriorMeans(std::vector<double>{0.9, 0.1, 0.5});
  BailOut();
  EXPECT_EQ(Frame().arm, 2U);
}

TEST_F(AdaptiveBroadPhaseTest, ABailOutDoesNotSwitchIfADeciderIsConnected) {
  adaptive_->SetDeciderPresent(true);
  BailOut();
  EXPECT_NE(sink_.frames.back().flags & kFrameBailOut, 0U);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, DoesNotBailOutInManualModeOrIfTheArmIsNotTheCause) {
  Frame(7 * kSecond);
  EXPECT_EQ(Frame().arm, 0U);
  BailOut(kFramePaused);
  EXPECT_EQ(Frame().arm, 0U);
  BailOut(kFrameLoading);
  EXPECT_EQ(Frame().arm, 0U);
  adaptive_->SetMode(Mode::kManual);
  BailOut();
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, SwitchesOncePerBailOut) {
  BailOut();
  for (int i = 0; i < 3; ++i) Frame();
  EXPECT_EQ(adaptive_->switch_epoch(), 1U);
  BailOut();
  for (int i = 0; i < 3; ++i) Frame();
  EXPECT_EQ(adaptive_->switch_epoch(), 2U);
  EXPECT_EQ(adaptive_->active_arm(), 2U);
}

TEST_F(AdaptiveBroadPhaseTest, KeepsOnlyTheFlagsThatAnEngineMaySet) {
  Frame();
  EXPECT_EQ(Frame(1, 4, 0xFFFF'FFF0U | kFrameBailOut | kFramePaused).flags, uint32_t{kFramePaused});
}

TEST_F(AdaptiveBroadPhaseTest, AFrameWithoutASearchHasNoDetectionTime) {
  Frame();
  adaptive_->BeginFrame();
  adaptive_->EndFrame({.frame_time_ns = 5, .flags = kFramePaused});
  EXPECT_EQ(adaptive_->last_sample().detection_time_ns, 0U);
  EXPECT_EQ(adaptive_->last_sample().frame_index, 1U);
  EXPECT_EQ(Frame().flags, 0U);
}

TEST_F(AdaptiveBroadPhaseTest, SumsTheSearchesOfAFrameAndCountsPairsOfTheLast) {
  adaptive_->BeginFrame();
  adaptive_->FindPairs(std::vector<Aabb>(4));
  arms_[0]->script().pair_count = 2;
  EXPECT_EQ(adaptive_->FindPairs(std::vector<Aabb>(5)).size(), 2U);
  adaptive_->EndFrame({.frame_time_ns = 5000});
  const FrameSample& sample = adaptive_->last_sample();
  EXPECT_EQ(sample.detection_time_ns, 1010U + 110U);
  EXPECT_EQ(sample.aabb_check_count, 5U + 5U);
  EXPECT_EQ(sample.native_bytes, 64U);
  EXPECT_EQ(sample.pair_count, 2U);
  EXPECT_EQ(sample.object_count, 5U);
  EXPECT_EQ(sample.flags, uint32_t{kFrameRebuild});
  EXPECT_EQ(arms_[0]->build_count, 1);
  EXPECT_EQ(arms_[0]->update_count, 1);
  EXPECT_EQ(sink_.frames.size(), 1U);
  EXPECT_EQ(Frame().detection_time_ns, 110U) << "the time starts at 0 in each frame";
}

TEST_F(AdaptiveBroadPhaseTest, MeasuresOnlyTheRebuildIfFramesSearchTwice) {
  AdaptiveOptions options;
  options.settling_ns = 100;
  Make(options);
  for (int frame = 0; frame < 4; ++frame) {
    if (frame == 1) adaptive_->mailbox().Post({.command_id = 9, .arm = 1});
    adaptive_->BeginFrame();
    for (int search = 0; search < 2; ++search) adaptive_->FindPairs(std::vector<Aabb>(4));
    adaptive_->EndFrame({.frame_time_ns = 50});
  }
  ASSERT_EQ(sink_.switches.size(), 1U);
  EXPECT_EQ(sink_.switches[0].rebuild_time_ns, 1000U);
  for (size_t frame = 0; frame < 4; ++frame) {
    EXPECT_EQ(sink_.frames[frame].flags, frame < 2 ? uint32_t{kFrameRebuild} : 0U);
  }
}

TEST_F(AdaptiveBroadPhaseTest, BailsOutIfTheSumOfSearchesIsTooLong) {
  arms_[0]->script().find_ns = 2 * kSecond;
  adaptive_->BeginFrame();
  for (int search = 0; search < 3; ++search) adaptive_->FindPairs(std::vector<Aabb>(4));
  adaptive_->EndFrame({.frame_time_ns = 7 * kSecond});
  EXPECT_EQ(Frame().arm, 1U);
}

// Each frame has two searches, the second with moved objects. If the second search were described,
// too, there would be twice as many descriptors, and they would show motion.
TEST_F(AdaptiveBroadPhaseTest, DescribesTheFirstSearchOfEachFrame) {
  const std::vector<Aabb> first(4, Aabb{{0, 0, 0}, {1, 1, 1}});
  const std::vector<Aabb> second(4, Aabb{{5, 0, 0}, {6, 1, 1}});
  for (int frame = 0; frame < 300; ++frame) {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(first);
    adaptive_->FindPairs(second);
    adaptive_->EndFrame({.frame_time_ns = 5});
  }
  ASSERT_EQ(sink_.descriptors.size(), 4U) << "one every 64 frames";
  EXPECT_EQ(sink_.descriptors[0].speed_mean, 0);
  EXPECT_EQ(sink_.descriptors[0].static_ratio, 1);
}

TEST_F(AdaptiveBroadPhaseTest, SortsPairsOnlyIfTheOptionIsSet) {
  const auto order = [this] {
    adaptive_->BeginFrame();
    const auto pairs = adaptive_->FindPairs(std::vector<Aabb>(4));
    const std::vector<uint32_t> firsts = {pairs[0].a, pairs[1].a, pairs[2].a};
    adaptive_->EndFrame({.frame_time_ns = 5});
    return firsts;
  };
  arms_[0]->script().descending = true;
  EXPECT_THAT(order(), ::testing::ElementsAre(2, 1, 0));
  AdaptiveOptions options;
  options.sorted_pairs = true;
  Make(options);
  arms_[0]->script().descending = true;
  EXPECT_THAT(order(), ::testing::ElementsAre(0, 1, 2));
}

TEST_F(AdaptiveBroadPhaseTest, DescribesTheSceneOncePerPeriod) {
  for (int i = 0; i < 600; ++i) Frame();
  ASSERT_EQ(sink_.descriptors.size(), 9U);
  EXPECT_EQ(sink_.descriptors[0].object_count, 4);
}

TEST_F(AdaptiveBroadPhaseTest, ReturnsArmsAndVersionsInOrder) {
  EXPECT_THAT(adaptive_->arms(), ::testing::ElementsAre("A", "B", "C"));
  EXPECT_THAT(adaptive_->arm_versions(), ::testing::ElementsAre(1, 2, 3));
}

}  // namespace
}  // namespace sweepstake
