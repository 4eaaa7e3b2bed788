// Tests trials: if an arm takes too long, the client stops its search, answers the frame from the
// former arm, and leaves the arm.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/guards/suspension_guard.h"
#include "engine_client/adaptive/guards/trial_guard.h"
#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::RecordingSink;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;

constexpr uint64_t kFrameNs = 10'000'000;
constexpr uint64_t kGrantedNs = kFrameNs / TrialGuard::kFrameShare;
constexpr uint64_t kUsualNs = 110;  // a search of A
constexpr uint64_t kTrialLimitNs = kUsualNs + kGrantedNs;
constexpr uint32_t kTrialFrames = 800;

// Arms A and B on a scripted clock; a search of each takes 110 ns. A trial lasts for kTrialFrames.
class TrialTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::unique_ptr<BroadPhase>> backends;
    for (const char* name : {"A", "B"}) {
      const ArmScript script{.name = name,
                             .build_ns = 1000,
                             .update_ns = 100,
                             .find_ns = 10,
                             .check_count = name[0] == 'A' ? 7U : 9U,
                             .bytes = 64,
                             .pair_count = name[0] == 'A' ? 3U : 5U};
      auto backend = std::make_unique<ScriptedBroadPhase>(script, clock_);
      arms_.push_back(backend.get());
      backends.push_back(std::move(backend));
    }
    const AdaptiveOptions options{.settling_ns = kTrialFrames / 2 * kFrameNs};
    adaptive_ = std::move(*AdaptiveFactory::Make(options, std::move(backends), &sink_, clock_));
    Frames(5);
  }

  const FrameSample& Frame(uint32_t flags = 0) {
    adaptive_->BeginFrame();
    Search();
    adaptive_->EndFrame({.frame_time_ns = frame_ns_, .flags = flags});
    return adaptive_->last_sample();
  }
  size_t Search() {
    const std::vector<Aabb> boxes(4);
    return adaptive_->FindPairs(boxes).size();
  }
  void FrameWithoutASearch() {
    adaptive_->BeginFrame();
    adaptive_->EndFrame({.frame_time_ns = frame_ns_});
  }
  void Frames(uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) Frame();
  }
  void Command(uint32_t limit_percent = 120) {
    adaptive_->mailbox().Post({.command_id = 7, .arm = 1, .trial_limit_percent = limit_percent});
  }
  // Commands arm B as a trial and runs its first frames: the first one builds, the others warm up.
  void TryB(uint32_t limit_percent = 120) {
    Command(limit_percent);
    ASSERT_EQ(Frame().flags, uint32_t{kFrameRebuild});
    Frames(kShadowWarmUpFrames);
  }
  // B's updates and searches poll as often as given.
  void SearchOfBTakes(uint64_t find_ns, uint32_t poll_count = 0) {
    arms_[1]->script().find_ns = find_ns;
    arms_[1]->script().poll_count = poll_count;
  }
  void SearchOfATakes(uint64_t find_ns) { arms_[0]->script().find_ns = find_ns; }
  void FramesTake(uint64_t frame_ns) { frame_ns_ = frame_ns; }

  uint64_t frame_ns_ = kFrameNs;
  ScriptedClock clock_;
  RecordingSink sink_;
  std::vector<ScriptedBroadPhase*> arms_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(TrialTest, StopsASearchOverTheLimitAndAnswersWithTheFormerArm) {
  TryB();
  SearchOfBTakes(100 * kGrantedNs, /*poll_count=*/1000);
  const FrameSample& stopped = Frame();
  constexpr uint64_t kStoppedNs = 100 + kGrantedNs + kGrantedNs / 10;
  EXPECT_EQ(stopped.arm, 0U);
  EXPECT_EQ(stopped.switch_epoch, 2U);
  EXPECT_EQ(stopped.detection_time_ns, kStoppedNs + kUsualNs);
  EXPECT_EQ(stopped.flags, 0U) << "arm A continues with its structure";
  EXPECT_EQ(stopped.pair_count, 3U);
  EXPECT_EQ(stopped.aabb_check_count, 7U);
  EXPECT_EQ(arms_[0]->build_count, 1);
  EXPECT_EQ(adaptive_->active_arm(), 0U);

  ASSERT_EQ(sink_.switches.size(), 2U);
  EXPECT_EQ(sink_.switches[0].command_id, 7U);
  EXPECT_EQ(sink_.switches[0].arm, 1U);
  EXPECT_EQ(sink_.switches[0].trial_detection_time_ns, 0U);
  EXPECT_EQ(sink_.switches[1].arm, 0U);
  EXPECT_EQ(sink_.switches[1].switch_epoch, 2U);
  EXPECT_EQ(sink_.switches[1].executed, 1U);
  EXPECT_EQ(sink_.switches[1].trial_detection_time_ns, kTrialLimitNs);
  EXPECT_EQ(sink_.switches[1].trial_arm, 1U);
  const FrameSample& next = Frame();
  EXPECT_EQ(next.arm, 0U);
  EXPECT_EQ(next.switch_epoch, 2U);
  EXPECT_EQ(next.detection_time_ns, kUsualNs);
}

// A short search ends before it polls. Its pairs are complete.
TEST_F(TrialTest, EndsAfterAFrameWhoseSearchCouldNotBeStopped) {
  TryB();
  SearchOfBTakes(kGrantedNs + 11);
  const FrameSample late = Frame();
  EXPECT_EQ(late.arm, 1U);
  EXPECT_EQ(late.detection_time_ns, kTrialLimitNs + 1);
  EXPECT_EQ(late.pair_count, 5U);
  const FrameSample& back = Frame();
  EXPECT_EQ(back.arm, 0U);
  EXPECT_EQ(back.switch_epoch, 2U);
  EXPECT_EQ(back.detection_time_ns, kUsualNs);
  EXPECT_EQ(back.flags, 0U) << "arm A continues with its structure";
  EXPECT_EQ(sink_.switches.back().trial_detection_time_ns, kTrialLimitNs + 1);
  EXPECT_EQ(sink_.switches.back().trial_arm, 1U);
}

TEST_F(TrialTest, AnArmWithinTheLimitStaysAfterTheTrial) {
  TryB();
  SearchOfBTakes(kGrantedNs + 10, /*poll_count=*/10);
  Frames(40);
  SearchOfBTakes(10);
  Frames(kTrialFrames - 40);
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  EXPECT_EQ(adaptive_->switch_epoch(), 1U);
}

// The first one builds the structure, which says little about the cost of B.
TEST_F(TrialTest, SearchesOfANewStructureMayTakeFiveTimesAsLong) {
  constexpr uint64_t kLongNs = kFrameNs / 10;  // more than the margin of a twentieth of a frame
  SearchOfATakes(kLongNs - 100);
  Frames(2 * TrialGuard::kBlockFrames);
  SearchOfBTakes(TrialGuard::kColdFactor * kLongNs - 1100, /*poll_count=*/100);
  TryB();
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  EXPECT_EQ(Frame().arm, 0U) << "after the warm-up the limit is lower";
}

TEST_F(TrialTest, ABuildThatTakesLongerIsStopped) {
  constexpr uint64_t kLongNs = kFrameNs / 10;
  SearchOfATakes(kLongNs - 100);
  Frames(2 * TrialGuard::kBlockFrames);
  arms_[1]->script().build_ns = TrialGuard::kColdFactor * kLongNs;
  SearchOfBTakes(kLongNs, /*poll_count=*/100);
  Command();
  const FrameSample& frame = Frame();
  EXPECT_EQ(frame.arm, 0U) << "the former arm answers the frame";
  EXPECT_LE(frame.detection_time_ns, (TrialGuard::kColdFactor + 2) * kLongNs);
}

TEST_F(TrialTest, IgnoresLongSearchesOfANewStructureThatCannotBeStopped) {
  SearchOfBTakes(kFrameNs);
  TryB();
  SearchOfBTakes(10);
  Frames(10);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, TheLimitFollowsTheLongestRecentSearchButOne) {
  SearchOfATakes(300'000);
  Frames(2);
  SearchOfATakes(10);
  Frames(200);
  TryB();
  SearchOfBTakes(300'000 + kGrantedNs);
  EXPECT_EQ(Frame().arm, 1U);
  EXPECT_EQ(Frame().arm, 1U);
  SearchOfBTakes(300'000 + kGrantedNs + 1);
  Frames(2);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

TEST_F(TrialTest, OneInterruptionOfTheFormerArmDoesNotRaiseTheLimit) {
  SearchOfATakes(100 * kFrameNs);
  Frame();
  SearchOfATakes(10);
  Frames(3);
  TryB();
  SearchOfBTakes(kGrantedNs + 11);
  Frames(2);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

TEST_F(TrialTest, TheLimitIgnoresOldLongSearches) {
  SearchOfATakes(kFrameNs);
  Frames(2);
  SearchOfATakes(10);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(kGrantedNs + 11);
  Frames(2);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

TEST_F(TrialTest, ALongSearchMayTakeAFifthLonger) {
  SearchOfATakes(5'000'000 - 100);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(6'000'000 - 100);
  Frame();
  EXPECT_EQ(Frame().arm, 1U);
  SearchOfBTakes(6'000'001 - 100);
  Frame();
  EXPECT_EQ(Frame().arm, 0U);
}

// Structures are rebuilt from time to time. A mean search of B saves 0.8 ms, and 0.5 ms count.
TEST_F(TrialTest, WhatTheTrialHasSavedRaisesTheLimitByOneMargin) {
  constexpr uint64_t kLongNs = kFrameNs / 10;
  SearchOfATakes(kLongNs - 100);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(kLongNs / 5 - 100);
  Frames(19);
  SearchOfBTakes(kLongNs + 2 * kGrantedNs - 100);
  Frame();
  EXPECT_EQ(Frame().arm, 1U);
  SearchOfBTakes(kLongNs + 2 * kGrantedNs - 99);
  Frame();
  EXPECT_EQ(Frame().arm, 0U);
  EXPECT_EQ(sink_.switches.back().trial_detection_time_ns,
            (19 * kLongNs / 5 + 3 * (kLongNs + 2 * kGrantedNs) + 1) / 22)
      << "the mean";
}

// An arm can be below the limit, but too expensive over the whole trial. In a trial of 8 s, 200 ms
// may be lost; 0.45 ms in each frame reach this after 445 frames.
TEST_F(TrialTest, EndsWhenTheTotalLossExceedsTheBudget) {
  TryB();
  SearchOfBTakes(450'010);
  Frames(445);
  EXPECT_EQ(adaptive_->last_sample().arm, 1U);
  ASSERT_EQ(Frame().arm, 0U);
  EXPECT_EQ(sink_.switches.back().trial_detection_time_ns, 450'110U) << "the mean of the trial";
}

TEST_F(TrialTest, AnArmWithinTheBudgetStays) {
  TryB();
  SearchOfBTakes(240'010);
  Frames(kTrialFrames);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, ATrialAfterACompletedOneIsComparedWithItsArm) {
  TryB();
  SearchOfBTakes(200'000);  // this is within the budget
  Frames(kTrialFrames);
  adaptive_->mailbox().Post({.command_id = 8, .arm = 0, .trial_limit_percent = 120});
  SearchOfATakes(kGrantedNs + 100'000);  // over A's limit, below B's limit
  Frames(1 + kShadowWarmUpFrames + 3);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  SearchOfATakes(kGrantedNs + 200'001);
  Frames(2);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

// Physics with substeps searches several times per frame.
TEST_F(TrialTest, TheSearchesOfAFrameHaveOneLimit) {
  TryB();
  SearchOfBTakes(kGrantedNs * 3 / 5, /*poll_count=*/10);
  adaptive_->BeginFrame();
  EXPECT_EQ(Search(), 5U);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  EXPECT_EQ(Search(), 3U);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  EXPECT_EQ(Search(), 3U);
  adaptive_->EndFrame({.frame_time_ns = kFrameNs});
  EXPECT_EQ(adaptive_->last_sample().arm, 0U);
  EXPECT_EQ(adaptive_->last_sample().switch_epoch, 2U);
  EXPECT_EQ(adaptive_->switch_epoch(), 2U);
}

// The time of a stopped frame is not a time of arm A.
TEST_F(TrialTest, AStoppedFrameDoesNotRaiseTheNextLimit) {
  for (int trial = 0; trial < 3; ++trial) {
    SearchOfBTakes(10);
    TryB();
    SearchOfBTakes(100 * kGrantedNs, /*poll_count=*/1000);
    EXPECT_EQ(Frame().arm, 0U);
    Frame();
  }
  EXPECT_LT(sink_.switches.back().trial_detection_time_ns, kTrialLimitNs + kGrantedNs / 5);
}

// Physics at 50 Hz searches only in some frames. The trial ends by time, as the decider expects.
TEST_F(TrialTest, FramesWithoutASearchCountForTheDuration) {
  TryB();
  for (uint32_t i = 0; i < kTrialFrames; ++i) FrameWithoutASearch();
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, ACommandWithoutALimitStartsNoTrial) {
  TryB(0);
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

// Other threads have the core for 6 s. Then the arm itself takes too long.
TEST_F(TrialTest, TimeWithoutTheCoreDoesNotEndATrial) {
  if (ThreadTimeNs() == 0) GTEST_SKIP() << "the CPU time of a thread is not precise here";
  clock_.ReportCpu();
  TryB();
  SearchOfBTakes(10, /*poll_count=*/10);
  for (const uint64_t waiting_ns : {kGrantedNs, 4 * kFrameNs}) {
    arms_[1]->script().waiting_ns = waiting_ns;
    Frame();
    EXPECT_EQ(Frame().arm, 1U);
  }
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(TrialTest, SuspendedFramesDoNotEndATrial) {
  clock_.ReportCpu();
  clock_.Advance(SuspensionGuard::kBaselineNs);
  Frame();
  TryB();
  arms_[1]->script().stopped_ns = 6'000'000'000;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(Frame().flags, uint32_t{kFrameSuspended});
    EXPECT_EQ(adaptive_->last_sample().arm, 1U);
  }
  arms_[1]->script().stopped_ns = 0;
  EXPECT_EQ(Frame().arm, 1U);
}

TEST_F(TrialTest, PausedAndLoadingFramesDoNotEndATrialThatWasNotStopped) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs);
  Frame(kFramePaused);
  Frame(kFrameLoading);
  Frame();
  EXPECT_EQ(adaptive_->last_sample().arm, 1U);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(TrialTest, TheFormerArmContinuesWithItsStructureAfterALongTrial) {
  TryB();
  Frames(kTrialFrames / 2);
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  EXPECT_EQ(Frame().flags, 0U);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  EXPECT_EQ(arms_[0]->build_count, 1);
}

TEST_F(TrialTest, AnArmThatWasStoppedIsBuiltAgain) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  Frame();
  SearchOfBTakes(10);
  TryB();
  EXPECT_EQ(arms_[1]->build_count, 2);
}

// A clock that advances by one step with each reading, so that every search takes one step.
class SteppedClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override { return now_ns_ += step_ns; }
  uint64_t step_ns = 100;

 private:
  uint64_t now_ns_ = 0;
};

// Ends a trial of a real arm and returns the flags of the next frame of the former arm.
uint32_t FlagsOfTheWayBack(bool trims) {
  SteppedClock clock;
  const AdaptiveOptions options{.arms = {"SAP", "DBVT"},
                                .initial_arm = "SAP",
                                .settling_ns = 20 * kFrameNs,
                                .shadow = {.enabled = ShadowMode::kOff}};
  const auto adaptive = std::move(*AdaptiveBroadPhase::Create(options, nullptr, clock));
  const std::vector<Aabb> boxes(4, Aabb{.min = {0, 0, 0}, .max = {1, 1, 1}});
  const auto frame = [&] {
    adaptive->BeginFrame();
    EXPECT_EQ(adaptive->FindPairs(boxes).size(), 6U);
    adaptive->EndFrame({.frame_time_ns = kFrameNs});
    return adaptive->last_sample();
  };
  for (int i = 0; i < 5; ++i) frame();
  adaptive->mailbox().Post({.command_id = 1, .arm = 1, .trial_limit_percent = 120});
  for (uint32_t i = 0; i <= kShadowWarmUpFrames; ++i) frame();
  EXPECT_EQ(adaptive->active_arm(), 1U);
  clock.step_ns = 2 * kGrantedNs;
  if (trims) adaptive->Trim();
  const FrameSample back = frame();
  EXPECT_EQ(back.arm, 0U);
  return back.flags;
}

TEST(Trial, TheFormerArmKeepsItsStructureUnlessItWasFreed) {
  EXPECT_EQ(FlagsOfTheWayBack(false), 0U);
  EXPECT_EQ(FlagsOfTheWayBack(true), uint32_t{kFrameRebuild});
}

TEST_F(TrialTest, AChoiceOfTheGameEndsATrial) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs);
  Frame();
  adaptive_->SetMode(Mode::kManual);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U) << "the end of the trial is dropped, too";
  ASSERT_TRUE(adaptive_->SelectArm("A").ok());
  Frame();
  for (const SwitchOutcome& outcome : sink_.switches)
    EXPECT_EQ(outcome.trial_detection_time_ns, 0U);
}

TEST_F(TrialTest, AChoiceOfTheGameDuringAFrameIsNotStopped) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs, /*poll_count=*/10);
  adaptive_->BeginFrame();
  ASSERT_TRUE(adaptive_->SelectArm("B").ok());
  EXPECT_EQ(Search(), 5U);
  adaptive_->EndFrame({.frame_time_ns = kFrameNs});
  EXPECT_EQ(Frame().arm, 1U);
}

}  // namespace
}  // namespace sweepstake
