#include "engine_client/adaptive/shadow_lane.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "tests/engine_client/adaptive/driven_lane.h"

namespace sweepstake {
namespace {

using test_support::kCopiesBytes;
using test_support::kMs;
using test_support::LaneBackend;
using test_support::LaneScript;
using test_support::RecordingSink;
using test_support::ScriptedClock;
using test_support::ThreeMsAtATime;
using Preparation = ShadowLane::Preparation;
using ShadowLaneTest = test_support::DrivenLane;

TEST_F(ShadowLaneTest, MeasuresEveryArmOnTheSameFrames) {
  scripts_[2].update_ns = 3 * kMs;
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  const std::vector<uint32_t> order{1, 0, 2};  // the active arm comes first
  for (size_t i = 0; i < 3; ++i) {
    const ShadowSample& sample = sink_.shadows[i];
    EXPECT_EQ(sample.arm, order[i]);
    EXPECT_EQ(sample.first_frame_index, 1U);
    EXPECT_EQ(sample.detection_time_ns, (sample.arm == 2 ? 4 : 2) * kMs);
    EXPECT_EQ(sample.build_time_ns, 6 * kMs);
    EXPECT_EQ(sample.aabb_check_count, 600U);  // Mean of frames 4 to 8: 400 to 800.
    EXPECT_EQ(sample.native_bytes, 1000U);
    EXPECT_EQ(sample.object_count, 20U);
    EXPECT_EQ(sample.frame_count, 5U);
    EXPECT_EQ(sample.flags, sample.arm == 1 ? uint32_t{kShadowActive} : 0U);
  }
  EXPECT_EQ(lane_->stats().sweep_count, 1U);
  EXPECT_EQ(lane_->stats().visit_count, 3U);
  EXPECT_EQ(lane_->stats().state, ShadowState::kRunning);
}

TEST_F(ShadowLaneTest, CopiesFramesOnlyForItsSweeps) {
  FirstSweep();
  EXPECT_EQ(lane_->stats().copied_frame_count, 8U);
  Frames(10);
  EXPECT_EQ(lane_->stats().copied_frame_count, 8U);
}

TEST_F(ShadowLaneTest, StaysWithinItsShareOfTheTime) {
  FirstSweep();
  const uint64_t begin_ns = clock_.NowNs();
  const uint64_t before_ns = lane_->stats().busy_time_ns;
  Frames(5000);
  const double share = static_cast<double>(lane_->stats().busy_time_ns - before_ns) /
                       static_cast<double>(clock_.NowNs() - begin_ns);
  EXPECT_LE(share, 0.15);
  EXPECT_GT(share, 0.10);
}

TEST_F(ShadowLaneTest, WorksAtMostAShareOfTheSearchesExceptForRareSweeps) {
  frames_per_search_time_ = 100;
  Frames(20'000);
  const uint64_t passed_ns = 20'000 * frame_ns_;
  // The lane may work kWorkAheadNs in advance, and has saved up the same amount. In addition it may
  // use half of the time that the searches take.
  const uint64_t allowed_ns = 2 * ShadowSchedule::kWorkAheadNs + passed_ns / 200;
  const uint64_t sweep_ns = 100 * kMs;
  EXPECT_LT(lane_->stats().busy_time_ns,
            allowed_ns + passed_ns / ShadowSchedule::kMaxSpacingNs * sweep_ns);
  EXPECT_GE(lane_->stats().sweep_count, passed_ns / ShadowSchedule::kMaxSpacingNs - 1);
}

// The first visit of a sweep begins with a warm-up, whose frames are not reported.
TEST_F(ShadowLaneTest, WarmsUpWithTheFirstVisitOfASweep) {
  std::vector<int> build_count(3, 0);
  for (uint32_t arm = 0; arm < 3; ++arm)
    scripts_[arm].in_build = [&build_count, arm] { ++build_count[arm]; };
  FirstSweep();
  EXPECT_THAT(build_count, testing::ElementsAre(1, 2, 1));
  EXPECT_EQ(lane_->stats().visit_count, 3U);
  const uint64_t frames_ns = (3 * kShadowBurstFrames + 1) * 2 * kMs + (3 + 1) * 4 * kMs;
  EXPECT_EQ(lane_->stats().busy_time_ns, frames_ns)
      << "the warm-up ends after one frame, because it takes longer than kShadowWarmUpNs";
}

TEST_F(ShadowLaneTest, CopyingTakesOnePercentOfTheFrames) {
  for (LaneScript& script : scripts_) script = {.build_ns = 1, .update_ns = 1, .find_ns = 1};
  // A copy takes 1 ms, so 1 % of the time of 80 frames of 10 ms allows 8 copies.
  clock_.SetReading(kMs);
  FirstSweep();
  const uint64_t begin = frame_index_;
  Frames(8000);
  const double copy_ms = static_cast<double>(lane_->stats().copy_time_ns) / kMs;
  EXPECT_LE(copy_ms, 0.01 * 10 * static_cast<double>(frame_index_ - begin) + 8);
  EXPECT_GT(copy_ms, 0.008 * 10 * static_cast<double>(frame_index_ - begin));
}

TEST_F(ShadowLaneTest, SweepsLessOftenIfItSlowsDownSearches) {
  Frames(5000);
  const uint64_t sweep_count = lane_->stats().sweep_count;
  EXPECT_GT(sweep_count, 50U);
  Make({});
  MakeItCost(/*slowdown=*/1);
  const uint64_t busy_before_ns = lane_->stats().busy_time_ns;
  Frames(5000);
  EXPECT_GE(lane_->stats().sweep_count, 2U);
  EXPECT_LT(lane_->stats().sweep_count, sweep_count / 5);
  // The frames take at least 50 s, and the lane has saved up 5 s.
  const auto busy_ns = static_cast<double>(lane_->stats().busy_time_ns - busy_before_ns);
  EXPECT_LT(busy_ns * lane_->cost().slowdown(), 1.1 * ShadowSchedule::kMaxCostRatio * 55e9);
}

TEST_F(ShadowLaneTest, EndsAVisitAtTheTimeCap) {
  scripts_[0].build_ns = 300 * kMs;
  scripts_[2].update_ns = 70 * kMs;
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[1].arm, 0U);
  EXPECT_EQ(sink_.shadows[1].flags, uint32_t{kShadowCapped});
  EXPECT_EQ(sink_.shadows[1].frame_count, 0U);
  EXPECT_EQ(sink_.shadows[1].detection_time_ns, 301 * kMs);
  EXPECT_EQ(sink_.shadows[2].flags, uint32_t{kShadowCapped});
  EXPECT_EQ(sink_.shadows[2].frame_count, 2U);
  EXPECT_EQ(sink_.shadows[2].detection_time_ns, 71 * kMs);
  EXPECT_EQ(lane_->stats().capped_visit_count, 2U);
}

// With eight frames of 100 ms per visit, the lane may work up to 200 ms per frame.
TEST_F(ShadowLaneTest, MeasuresArmsOfAGameWithLongFrames) {
  frame_ns_ = 100 * kMs;
  scripts_[1].update_ns = 90 * kMs;
  scripts_[0].update_ns = 190 * kMs;
  scripts_[2].update_ns = 300 * kMs;
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[0].flags, uint32_t{kShadowActive});
  EXPECT_EQ(sink_.shadows[0].detection_time_ns, 91 * kMs);
  EXPECT_EQ(sink_.shadows[1].flags, 0U);
  EXPECT_EQ(sink_.shadows[1].detection_time_ns, 191 * kMs);
  EXPECT_EQ(sink_.shadows[2].flags, uint32_t{kShadowCapped});
}

TEST_F(ShadowLaneTest, LimitsAVisitDuringAPause) {
  frame_ns_ = 3'600'000 * kMs;
  scripts_[0].question_count = 100'000;
  scripts_[0].question_ns = 10 * kMs;
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[1].flags, uint32_t{kShadowCapped});
  EXPECT_LE(sink_.shadows[1].detection_time_ns, 17'000 * kMs);
}

TEST_F(ShadowLaneTest, EndsARunningSearchAtTheTimeCap) {
  scripts_[0].question_count = 1000;
  scripts_[0].question_ns = 10 * kMs;
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[1].arm, 0U);
  EXPECT_EQ(sink_.shadows[1].flags, uint32_t{kShadowCapped});
  EXPECT_EQ(sink_.shadows[1].frame_count, 0U);
  EXPECT_EQ(sink_.shadows[1].detection_time_ns, 256 * kMs);
  EXPECT_EQ(sink_.shadows[2].flags, 0U);
  EXPECT_EQ(lane_->stats().capped_visit_count, 1U);
}

TEST_F(ShadowLaneTest, DoesNotCapAVisitThatWaitedForACore) {
  thread_time_ns_ = ThreeMsAtATime;
  scripts_[0].question_count = 1000;
  scripts_[0].question_ns = 10 * kMs;
  Make({});
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 2U);
  EXPECT_EQ(sink_.shadows[0].arm, 1U);
  EXPECT_EQ(sink_.shadows[1].arm, 2U);
  EXPECT_EQ(lane_->stats().capped_visit_count, 0U);
  // The arm is visited again in the next sweep.
  scripts_[0].question_count = 0;
  const uint64_t sweep_count = lane_->stats().sweep_count;
  while (lane_->stats().sweep_count == sweep_count) Frame();
  ASSERT_EQ(sink_.shadows.size(), 5U);
  EXPECT_EQ(sink_.shadows[3].arm, 0U);
}

// Thread time passes as the clock does, except while the process is stopped.
ScriptedClock* clock_of_lane = nullptr;
uint64_t ThreadTimeOfLane() noexcept { return clock_of_lane->ThreadCpuNs(); }

// A lane with a precise thread time, or only with the clock's coarse one, as on Windows.
class StoppedLaneTest : public ShadowLaneTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    clock_.ReportCpu();
    clock_of_lane = &clock_;
    if (GetParam()) thread_time_ns_ = ThreadTimeOfLane;
    Make({});
  }
};
INSTANTIATE_TEST_SUITE_P(ThreadTime, StoppedLaneTest, testing::Bool());

// The process is stopped during the second, fifth or first frame of a visit to arm 0.
TEST_P(StoppedLaneTest, AStopOfTheProcessIsNoCostOfAnArm) {
  scripts_[0].question_count = 1;
  uint64_t stopped_search = 0;
  uint64_t searches = 0;
  scripts_[0].in_search = [&](uint64_t) {
    clock_.AdvanceWaiting(++searches == stopped_search ? 6'000 * kMs : 0);
  };
  for (const uint64_t search : {1U, 2U, 5U}) {
    stopped_search = search;
    searches = 0;
    Make({});
    FirstSweep();
    const bool is_measured = search == 5;
    ASSERT_EQ(sink_.shadows.size(), is_measured ? 3U : 2U) << search;
    EXPECT_EQ(lane_->stats().capped_visit_count, 0U) << search;
    EXPECT_EQ(lane_->stats().visit_count, 3U) << search;
    if (!is_measured) continue;
    EXPECT_EQ(sink_.shadows[1].arm, 0U);
    EXPECT_EQ(sink_.shadows[1].flags, 0U);
    EXPECT_EQ(sink_.shadows[1].frame_count, 1U);
    EXPECT_EQ(sink_.shadows[1].detection_time_ns, 2 * kMs);
  }
}

// Only the build of arm 0 is stopped, so that no check for a stop follows within the frame.
TEST_P(StoppedLaneTest, AFrameThatWasStoppedCountsOnlyWithAPreciseTime) {
  scripts_[0].in_build = [&] { clock_.AdvanceWaiting(6'000 * kMs); };
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), GetParam() ? 3U : 2U);
  EXPECT_EQ(lane_->stats().capped_visit_count, 0U);
  EXPECT_EQ(sink_.shadows[1].build_time_ns, 6 * kMs) << "arm 0, or else arm 2";
}

// Each sweep costs the frame thread a part of its duration. With the stop as a part of that
// duration, the next sweep would begin minutes later.
TEST_P(StoppedLaneTest, SweepsAgainSoonAfterAStopOfTheProcess) {
  MakeItCost(1);
  uint64_t searches = 0;
  scripts_[0].question_count = 1;
  scripts_[0].in_search = [&](uint64_t) {
    clock_.AdvanceWaiting(++searches == 5 ? 6'000 * kMs : 0);
  };
  FirstSweep();
  Frames(3'000);  // 30 s
  EXPECT_GE(lane_->stats().sweep_count, 2U);
}

TEST_F(ShadowLaneTest, ACappedVisitMeasuresTheFramesBefore) {
  uint64_t searches = 0;
  scripts_[0].question_count = 1;
  scripts_[0].in_search = [&](uint64_t) { clock_.Advance(++searches == 6 ? 400 * kMs : 0); };
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[1].flags, uint32_t{kShadowCapped});
  EXPECT_EQ(sink_.shadows[1].frame_count, 2U);
  EXPECT_EQ(sink_.shadows[1].detection_time_ns, 2 * kMs);
}

TEST_F(ShadowLaneTest, EndsAVisitIfThePairsExceedTheMemoryCap) {
  scripts_[0].question_count = 1000;
  scripts_[0].question_bytes = 20'000;
  uint64_t asked = 0;
  scripts_[0].in_search = [&](uint64_t) { ++asked; };
  Make({.memory_cap_bytes = 200'000});
  FirstSweep();
  EXPECT_EQ(asked, 6U);  // 6 × 20,000 bytes exceed half of the cap.
  ASSERT_EQ(sink_.shadows.size(), 2U) << "the time of an ended search is not reported";
  EXPECT_EQ(sink_.shadows[1].arm, 2U);
  EXPECT_EQ(lane_->stats().visit_count, 3U);
  EXPECT_EQ(lane_->stats().capped_visit_count, 1U);
  Frames(400);
  EXPECT_GE(lane_->stats().sweep_count, 8U);
  EXPECT_LE(asked, 6U * (1 + lane_->stats().sweep_count / 2)) << "the arm is visited less often";
  EXPECT_LE(FramesUntilReady(0), 2);
  EXPECT_EQ(lane_->Ask(0), Preparation::kNever);
}

TEST_F(ShadowLaneTest, ASwitchInterruptsASearch) {
  scripts_[0].question_count = 1000;
  uint64_t asked = 0;
  scripts_[0].in_search = [&](uint64_t question) {
    ++asked;
    if (question == 3) lane_->Ask(2);
  };
  FirstSweep();
  EXPECT_EQ(asked, 3U);
  EXPECT_EQ(sink_.shadows.size(), 1U) << "the visit of arm 0 was interrupted";
  EXPECT_EQ(FramesUntilReady(2), static_cast<int>(ShadowLane::kPreparationFrames) + 1);
}

TEST_F(ShadowLaneTest, ACancelInterruptsTheSearchOfAPreparation) {
  FirstSweep();
  uint64_t asked = 0;
  scripts_[2].question_count = 1000;
  scripts_[2].in_search = [&](uint64_t question) {
    ++asked;
    if (question == 3) lane_->Cancel();
  };
  lane_->Ask(2);
  Frames(3);
  EXPECT_EQ(asked, 3U);
  scripts_[2].question_count = 0;
  FramesUntilReady(2);
  ArmBackend own = MakeBackend(2);
  ASSERT_TRUE(lane_->TakeOver(2, own, pairs_));
  EXPECT_EQ(static_cast<LaneBackend&>(*own.backend).shown.size(), ShadowLane::kPreparationFrames)
      << "frames since the build";
}

TEST_F(ShadowLaneTest, TheDestructorEndsASearchOnItsThread) {
  std::atomic<bool> is_searching{false};
  scripts_.resize(2);
  for (LaneScript& script : scripts_) {
    script.question_count = std::numeric_limits<uint64_t>::max();
    script.in_search = [&](uint64_t) { is_searching = true; };
  }
  Make({.visit_cap_ns = std::numeric_limits<uint64_t>::max()}, SteadyClock());
  lane_->Start();
  while (!is_searching) {
    lane_->OnFrame(std::vector<Aabb>(20), {.frame_index = frame_index_++, .frame_time_ns = 1});
    std::this_thread::yield();
  }
  lane_.reset();
  EXPECT_TRUE(sink_.shadows.empty());
}

TEST_F(ShadowLaneTest, CopiesFewerFramesWithLittleMemory) {
  // 20 objects with slack are 86 boxes, 2,064 bytes per frame, so five frames fit in half of the
  // cap.
  Make({.memory_cap_bytes = 2 * 5 * 2064});
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[0].frame_count, 2U);
  EXPECT_EQ(lane_->stats().copied_frame_count, 5U);
}

TEST_F(ShadowLaneTest, PausesWhileTheSceneExceedsItsMemory) {
  Make({.memory_cap_bytes = 2 * 4 * 2064 - 2});
  FirstSweep();
  Frames(500);
  EXPECT_EQ(lane_->stats().state, ShadowState::kTooBig);
  EXPECT_EQ(lane_->stats().copied_frame_count, 0U);
  EXPECT_EQ(lane_->Ask(0), Preparation::kNever);
  EXPECT_TRUE(sink_.shadows.empty());
  object_count_ = 5;
  Frames(200);
  EXPECT_EQ(lane_->stats().state, ShadowState::kRunning);
  EXPECT_FALSE(sink_.shadows.empty());
}

TEST_F(ShadowLaneTest, KeepsStructuresWithinItsMemory) {
  for (LaneScript& script : scripts_) script.bytes = 40'000;
  Make({.memory_cap_bytes = 200'000});
  for (int i = 0; i < 40; ++i) {
    Frames(10);
    EXPECT_LE(lane_->stats().memory_bytes, 200'000U);
  }
  EXPECT_GT(lane_->stats().memory_bytes, 80'000U);
  EXPECT_GT(made_count_, 3);  // The third structure was freed each time.
}

TEST_F(ShadowLaneTest, CountsItsCopiesBeforeItsFirstVisit) {
  lane_->Step();
  Frame();
  EXPECT_EQ(lane_->stats().visit_count, 0U);
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes);
}

TEST_F(ShadowLaneTest, CountsAPreparedStructureUntilItIsTaken) {
  lane_->Ask(2);
  FramesUntilReady(2);
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes + scripts_[2].bytes);
  ArmBackend own = MakeBackend(2);
  ASSERT_TRUE(lane_->TakeOver(2, own, pairs_));
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes);
}

TEST_F(ShadowLaneTest, FreesAPreparedStructureOverTheMemoryCap) {
  scripts_[0].bytes = 150'000;
  Make({.memory_cap_bytes = 200'000});
  lane_->Ask(0);
  FramesUntilReady(0);
  EXPECT_EQ(lane_->Ask(0), Preparation::kNever);
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes);
}

TEST_F(ShadowLaneTest, FreesOtherStructuresForAPreparation) {
  for (LaneScript& script : scripts_) script.bytes = 40'000;
  Make({.memory_cap_bytes = 200'000});
  FirstSweep();
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes + 80'000) << "two of them fit";
  lane_->Ask(2);
  FramesUntilReady(2);
  EXPECT_EQ(lane_->Ask(2), Preparation::kReady);
  EXPECT_EQ(lane_->stats().memory_bytes, kCopiesBytes + 40'000);
}

TEST_F(ShadowLaneTest, TrimFreesItsMemoryAndItContinues) {
  FirstSweep();
  lane_->Trim();
  lane_->Step();
  EXPECT_EQ(lane_->stats().memory_bytes, 0U);
  Frames(200);
  EXPECT_GE(lane_->stats().sweep_count, 2U);
}

TEST_F(ShadowLaneTest, TrimKeepsAStructureForASwitch) {
  FirstSweep();
  lane_->Ask(2);
  FramesUntilReady(2);
  lane_->Trim();
  Frame();
  ArmBackend own = MakeBackend(2);
  EXPECT_TRUE(lane_->TakeOver(2, own, pairs_));
  EXPECT_FALSE(static_cast<LaneBackend&>(*own.backend).shown.empty());
}

TEST_F(ShadowLaneTest, EndsAVisitAfterOneFrameIfTheStructureExceedsTheMemoryCap) {
  scripts_[0].bytes = 150'000;
  Make({.memory_cap_bytes = 200'000});
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 3U);
  EXPECT_EQ(sink_.shadows[1].flags, uint32_t{kShadowCapped});
  EXPECT_LE(lane_->stats().memory_bytes, 200'000U);
  EXPECT_LE(FramesUntilReady(0), 2);
  EXPECT_EQ(lane_->Ask(0), Preparation::kNever);
}

TEST_F(ShadowLaneTest, PausesInManualModeUntilTheFirstAiModeUnlessOn) {
  mode_ = Mode::kManual;
  FirstSweep();
  EXPECT_EQ(lane_->stats().state, ShadowState::kPaused);
  EXPECT_EQ(lane_->stats().copied_frame_count, 0U);
  EXPECT_EQ(lane_->Ask(0), Preparation::kNever);
  mode_ = Mode::kAi;
  FirstSweep();
  EXPECT_EQ(sink_.shadows.size(), 3U);
  mode_ = Mode::kManual;
  EXPECT_EQ(lane_->stats().state, ShadowState::kRunning);
  Make({.enabled = ShadowMode::kOn});
  FirstSweep();
  EXPECT_EQ(sink_.shadows.size(), 3U);
}

TEST_F(ShadowLaneTest, MeasuresScenesWithAChangingObjectCount) {
  lane_->Step();
  for (int frame = 0; frame < 200; ++frame) {
    object_count_ = 20 + static_cast<size_t>(frame % 7);
    Frame();
  }
  EXPECT_GE(sink_.shadows.size(), 6U);
  object_count_ = 500;
  Frames(200);
  EXPECT_EQ(sink_.shadows.back().object_count, 500U);
}

TEST_F(ShadowLaneTest, MeasuresNothingInAnEmptyScene) {
  object_count_ = 0;
  FirstSweep();
  Frames(100);
  EXPECT_TRUE(sink_.shadows.empty());
}

TEST_F(ShadowLaneTest, PreparesASwitchAndExchangesTheBackends) {
  FirstSweep();
  EXPECT_EQ(lane_->Ask(2), Preparation::kUnderWay);
  EXPECT_EQ(FramesUntilReady(2), static_cast<int>(ShadowLane::kPreparationFrames) + 1);
  ArmBackend own = MakeBackend(2);
  const BroadPhase* before = own.backend.get();
  ASSERT_TRUE(lane_->TakeOver(2, own, pairs_));
  EXPECT_NE(own.backend.get(), before);
  EXPECT_EQ(static_cast<LaneBackend&>(*own.backend).shown.size(), ShadowLane::kPreparationFrames);
  EXPECT_FALSE(lane_->TakeOver(2, own, pairs_));
  lane_->Cancel();
  Frames(200);  // The lane now uses the test's former backend.
  EXPECT_GE(lane_->stats().sweep_count, 2U);
}

TEST_F(ShadowLaneTest, PreparesASwitchBeforeItsFirstSweep) {
  EXPECT_EQ(lane_->Ask(2), Preparation::kUnderWay);
  EXPECT_LE(FramesUntilReady(2), 2 + static_cast<int>(ShadowLane::kPreparationFrames));
  EXPECT_EQ(lane_->Ask(2), Preparation::kReady);
  EXPECT_TRUE(sink_.shadows.empty());
}

TEST_F(ShadowLaneTest, APreparationReplacesThatOfAnotherArm) {
  FirstSweep();
  lane_->Ask(2);
  Frames(2);
  lane_->Ask(0);
  FramesUntilReady(0);
  ArmBackend own = MakeBackend(0);
  EXPECT_FALSE(lane_->TakeOver(2, own, pairs_));
  EXPECT_TRUE(lane_->TakeOver(0, own, pairs_));
}

TEST_F(ShadowLaneTest, UpdatesAnOutdatedStructureBeforeOfferingIt) {
  FirstSweep();
  lane_->Ask(2);
  Frames(4);
  // The lane receives these frames but gets no step, so that it falls behind.
  for (int i = 0; i < 10; ++i) {
    lane_->OnFrame(std::vector<Aabb>(7), {.frame_index = frame_index_++});
  }
  object_count_ = 9;
  FramesUntilReady(2);
  ArmBackend own = MakeBackend(2);
  ASSERT_TRUE(lane_->TakeOver(2, own, pairs_));
  EXPECT_EQ(static_cast<LaneBackend&>(*own.backend).shown.back(), 9U);
}

TEST_F(ShadowLaneTest, SweepsAgainAfterASwitchWithoutItsPreparation) {
  ArmBackend own;
  EXPECT_EQ(lane_->Ask(2), Preparation::kUnderWay);
  EXPECT_FALSE(lane_->TakeOver(2, own, pairs_));
  Frames(100);
  EXPECT_GE(lane_->stats().sweep_count, 1U);
}

TEST_F(ShadowLaneTest, ASwitchInterruptsASweep) {
  scripts_[0].in_build = [this] { lane_->Ask(2); };
  FirstSweep();
  ASSERT_EQ(sink_.shadows.size(), 1U);  // The active arm only; the visit of arm 0 was interrupted.
  EXPECT_EQ(lane_->stats().sweep_count, 0U);
  scripts_[0].in_build = [] {};
  FramesUntilReady(2);
  EXPECT_EQ(lane_->Ask(2), Preparation::kReady);
  lane_->Cancel();
  Frames(500);
  EXPECT_GE(lane_->stats().sweep_count, 1U);
}

TEST_F(ShadowLaneTest, FreesItsMemoryAndRetriesIfAnAllocationFails) {
  scripts_[0].in_build = [] { throw std::bad_alloc(); };
  FirstSweep();
  EXPECT_EQ(sink_.shadows.size(), 1U);
  EXPECT_EQ(lane_->stats().memory_bytes, 0U);
  scripts_[0].in_build = [] {};
  Frames(90);
  EXPECT_EQ(sink_.shadows.size(), 1U);
  Frames(30);
  EXPECT_EQ(sink_.shadows.size(), 4U);
}

}  // namespace
}  // namespace sweepstake
