// Tests trials: if an arm takes too long, the client itself leaves it in the next frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/guards/suspension_guard.h"
#include "engine_client/adaptive/guards/trial_guard.h"
#include "engine_client/adaptive/shadow_schedule.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::RecordingSink;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;

constexpr uint64_t kFrameNs = 10'000'000;
constexpr uint64_t kGrantedNs = 2'000'000;  // 20 % of a frame
constexpr uint32_t kTrialFrames = 800;

// Arms A and B on a scripted clock; a search of each takes 110 ns. A trial lasts for kTrialFrames.
class TrialTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::unique_ptr<BroadPhase>> backends;
    for (const char* name : {"A", "B"}) {
      const ArmScript script{
          .name = name, .build_ns = 1000, .update_ns = 100, .find_ns = 10, .bytes = 64};
      auto backend = std::make_unique<ScriptedBroadPhase>(script, clock_);
      arms_.push_back(backend.get());
      backends.push_back(std::move(backend));
    }
    const AdaptiveOptions options{.settling_ns = kTrialFrames / 2 * kFrameNs};
    adaptive_ = std::move(*AdaptiveFactory::Make(options, std::move(backends), &sink_, clock_));
    Frames(5);
  }

  const FrameSample& Frame(uint32_t flags = 0) {
    const std::vector<Aabb> boxes(4);
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes);
    adaptive_->EndFrame({.frame_time_ns = frame_ns_, .flags = flags});
    return adaptive_->last_sample();
  }
  void FrameWithoutASearch() {
    adaptive_->BeginFrame();
    adaptive_->EndFrame({.frame_time_ns = frame_ns_});
  }
  void Frames(uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) Frame();
  }
  // Commands arm B as a trial of at most 110 ns + kGrantedNs. The frames here (the first builds,
  // the others warm up) do not count for the limit.
  void TryB(uint32_t limit_percent = 120) {
    adaptive_->mailbox().Post({.command_id = 7, .arm = 1, .trial_limit_percent = limit_percent});
    ASSERT_EQ(Frame().flags, uint32_t{kFrameRebuild});
    Frames(kShadowWarmUpFrames);
  }
  void SearchOfBTakes(uint64_t find_ns) { arms_[1]->script().find_ns = find_ns; }
  void FramesTake(uint64_t frame_ns) { frame_ns_ = frame_ns; }

  uint64_t frame_ns_ = kFrameNs;
  ScriptedClock clock_;
  RecordingSink sink_;
  std::vector<ScriptedBroadPhase*> arms_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(TrialTest, EndsAfterTwoFramesOverTheLimit) {
  TryB();
  SearchOfBTakes(kGrantedNs + 40);
  EXPECT_EQ(Frame().detection_time_ns, kGrantedNs + 140);
  SearchOfBTakes(kGrantedNs + 20);
  EXPECT_EQ(Frame().detection_time_ns, kGrantedNs + 120);
  const FrameSample& back = Frame();
  EXPECT_EQ(back.arm, 0U);
  EXPECT_EQ(back.switch_epoch, 2U);
  EXPECT_EQ(back.detection_time_ns, 110U);
  EXPECT_EQ(back.flags, 0U) << "arm A continues with its structure";
  EXPECT_EQ(arms_[0]->build_count, 1);

  ASSERT_EQ(sink_.switches.size(), 2U);
  EXPECT_EQ(sink_.switches[0].command_id, 7U);
  EXPECT_EQ(sink_.switches[0].arm, 1U);
  EXPECT_EQ(sink_.switches[0].trial_detection_time_ns, 0U);
  EXPECT_EQ(sink_.switches[1].arm, 0U);
  EXPECT_EQ(sink_.switches[1].switch_epoch, 2U);
  EXPECT_EQ(sink_.switches[1].executed, 1U);
  EXPECT_EQ(sink_.switches[1].trial_detection_time_ns, kGrantedNs + 120)
      << "the shorter of the two frames counts";
  EXPECT_EQ(sink_.switches[1].trial_arm, 1U);
  Frames(100);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

TEST_F(TrialTest, AnArmWithinTheLimitStaysAfterTheTrial) {
  TryB();
  SearchOfBTakes(kGrantedNs + 10);
  Frames(40);
  SearchOfBTakes(10);
  Frames(kTrialFrames - 40);
  SearchOfBTakes(2 * kGrantedNs);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  EXPECT_EQ(adaptive_->switch_epoch(), 1U);
}

TEST_F(TrialTest, IgnoresTheBuildAndWarmUpFrames) {
  SearchOfBTakes(100 * kGrantedNs);
  TryB();
  SearchOfBTakes(10);
  Frames(10);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, IgnoresSingleFramesOverTheLimit) {
  TryB();
  for (int i = 0; i < 5; ++i) {
    SearchOfBTakes(100 * kGrantedNs);
    Frame();
    SearchOfBTakes(10);
    Frame();
  }
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, TheLimitFollowsTheLongestRecentFrame) {
  FramesTake(2 * kFrameNs);
  arms_[0]->script().find_ns = 100;
  Frame();
  FramesTake(kFrameNs);
  arms_[0]->script().find_ns = 10;
  Frames(200);
  TryB();
  SearchOfBTakes(2 * kGrantedNs + 100);
  Frames(2);
  EXPECT_EQ(Frame().arm, 1U) << "a frame twice as long took 200 ns before";
  SearchOfBTakes(2 * kGrantedNs + 101);
  Frames(3);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

TEST_F(TrialTest, TheLimitIgnoresAnOldLongFrame) {
  FramesTake(2 * kFrameNs);
  arms_[0]->script().find_ns = 100;
  Frame();
  FramesTake(kFrameNs);
  arms_[0]->script().find_ns = 10;
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(kGrantedNs + 11);
  Frames(3);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

// At 1,000 frames/s, 20 % of a frame is shorter than common interruptions, so the limit has a
// minimum.
TEST_F(TrialTest, TheLimitIsAtLeastOneMillisecond) {
  FramesTake(1'000'000);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(TrialGuard::kLeastNs + 10);
  Frames(3);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  SearchOfBTakes(TrialGuard::kLeastNs + 11);
  Frames(3);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

// An arm can be below the limit of a single frame, but too expensive over the whole trial. In a
// trial of 8 s, 200 ms may be lost; 0.9 ms in each frame reach this after 223 frames.
TEST_F(TrialTest, EndsWhenTheTotalLossExceedsTheBudget) {
  FramesTake(1'000'000);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(900'010);
  Frames(223);
  EXPECT_EQ(adaptive_->last_sample().arm, 1U);
  ASSERT_EQ(Frame().arm, 0U);
  EXPECT_EQ(sink_.switches.back().trial_detection_time_ns, 900'110U) << "the mean of the trial";
}

TEST_F(TrialTest, AnArmWithinTheBudgetStays) {
  FramesTake(1'000'000);
  Frames(2 * TrialGuard::kBlockFrames);
  TryB();
  SearchOfBTakes(24'010);
  Frames(8'000);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

// One long frame counts at most 1/kFrameShare of the budget, because interruptions affect single
// frames.
TEST_F(TrialTest, OneLongFrameDoesNotExceedTheBudget) {
  TryB();
  for (uint64_t i = 0; i < TrialGuard::kFrameShare; ++i) {
    SearchOfBTakes(1'000'000'000);
    Frame();
    SearchOfBTakes(10);
    Frames(10);
  }
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  SearchOfBTakes(1'000'000'000);
  Frame();
  SearchOfBTakes(10);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(TrialTest, ATrialAfterACompletedOneIsComparedWithItsArm) {
  TryB();
  SearchOfBTakes(kGrantedNs / 10);  // this is within the budget
  Frames(kTrialFrames);
  adaptive_->mailbox().Post({.command_id = 8, .arm = 0, .trial_limit_percent = 120});
  Frame();
  arms_[0]->script().find_ns = kGrantedNs + kGrantedNs / 20;  // over A's limit, below B's limit
  Frames(kShadowWarmUpFrames + 3);
  EXPECT_EQ(adaptive_->active_arm(), 0U);
  arms_[0]->script().find_ns = kGrantedNs + kGrantedNs / 5;
  Frames(3);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

// The frames are so long that five of them take longer than the trial. The first three are the
// build and the warm-up.
TEST_F(TrialTest, EndsIfFramesAreAlmostAsLongAsTheTrial) {
  const uint64_t long_ns = kTrialFrames * kFrameNs * 3 / 8;
  adaptive_->mailbox().Post({.command_id = 7, .arm = 1, .trial_limit_percent = 120});
  SearchOfBTakes(long_ns);
  FramesTake(long_ns);
  Frames(1 + kShadowWarmUpFrames + 2);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
  EXPECT_EQ(Frame().arm, 0U);
}

// Physics at 50 Hz searches only in some frames. The trial ends by time, as the decider expects.
TEST_F(TrialTest, FramesWithoutASearchCountForTheDuration) {
  TryB();
  for (uint32_t i = 0; i < kTrialFrames; ++i) FrameWithoutASearch();
  SearchOfBTakes(2 * kGrantedNs);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
}

TEST_F(TrialTest, FramesWithoutASearchDoNotInterruptTwoSlowFrames) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs);
  Frame();
  FrameWithoutASearch();
  EXPECT_EQ(Frame().arm, 1U);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(TrialTest, ACommandWithoutALimitStartsNoTrial) {
  TryB(0);
  SearchOfBTakes(2 * kGrantedNs);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U);
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

TEST_F(TrialTest, PausedAndLoadingFramesDoNotEndATrial) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs);
  Frame(kFramePaused);
  Frame(kFrameLoading);
  Frame();
  EXPECT_EQ(Frame().arm, 1U);
  EXPECT_EQ(Frame().arm, 0U);
}

TEST_F(TrialTest, TheFormerArmBuildsAgainAfterALongTrial) {
  TryB();
  Frames(30);
  SearchOfBTakes(2 * kGrantedNs);
  Frames(2);
  EXPECT_EQ(Frame().flags, uint32_t{kFrameRebuild});
  EXPECT_EQ(adaptive_->active_arm(), 0U);
}

// A clock that advances by one step with each reading, so that every search takes one step.
class SteppedClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override { return now_ns_ += step_ns; }
  uint64_t step_ns = 100;

 private:
  uint64_t now_ns_ = 0;
};

// Ends a trial of a real arm and returns the flags of the next frame.
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
  clock.step_ns = 2 * kGrantedNs;
  frame();
  EXPECT_EQ(frame().arm, 1U);
  if (trims) adaptive->Trim();
  const FrameSample back = frame();
  EXPECT_EQ(back.arm, 0U);
  return back.flags;
}

TEST(Trial, TheFormerArmKeepsItsStructureUnlessItWasFreed) {
  EXPECT_EQ(FlagsOfTheWayBack(false), 0U);
  EXPECT_EQ(FlagsOfTheWayBack(true), uint32_t{kFrameRebuild});
}

TEST_F(TrialTest, AChoiceOfTheGameReportsNoEndedTrial) {
  TryB();
  SearchOfBTakes(2 * kGrantedNs);
  Frames(2);
  adaptive_->SetMode(Mode::kManual);
  Frames(5);
  EXPECT_EQ(adaptive_->active_arm(), 1U) << "the choice of the former frame is dropped, too";
  ASSERT_TRUE(adaptive_->SelectArm("A").ok());
  Frame();
  for (const SwitchOutcome& outcome : sink_.switches)
    EXPECT_EQ(outcome.trial_detection_time_ns, 0U);
}

}  // namespace
}  // namespace sweepstake
