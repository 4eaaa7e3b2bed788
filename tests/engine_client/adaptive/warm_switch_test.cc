// Tests switches that the shadow lane's own thread prepares, on real backends.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/support/pair_oracle.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_clock.h"

namespace sweepstake {
namespace {

using test_support::PairDifference;
using test_support::RecordingSink;
using test_support::ScalarPairs;

using test_support::kMs;

// Runs the parts one after another. Fails if a thread other than its creator calls it.
class LoneExecutor final : public Executor {
 public:
  size_t thread_count() const noexcept override { return 2; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    EXPECT_EQ(std::this_thread::get_id(), owner_);
    ++call_count;
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }

  std::atomic<int> call_count{0};

 private:
  const std::thread::id owner_ = std::this_thread::get_id();
};

ArmBackend MakeArm(std::string_view name, Executor* executor) {
  ArmBackend made;
  if (executor != nullptr) made.executor = std::make_unique<DetachableExecutor>(*executor);
  made.backend = std::move(*MakeBroadPhase(name, {.executor = made.executor.get()}));
  return made;
}

template <size_t count>
size_t Cores() noexcept {
  return count;
}

// All arms on a machine with spare cores, in a moving scene.
class WarmSwitchTest : public ::testing::Test {
 protected:
  void Make(AdaptiveOptions options, size_t (*cores)() noexcept = Cores<8>,
            Clock& clock = SteadyClock()) {
    const auto make = [executor = options.executor](uint32_t arm) {
      return MakeArm(BroadPhaseNames()[arm], executor);
    };
    std::vector<ArmBackend> backends;
    for (uint32_t arm = 0; arm < arm_count_; ++arm) backends.push_back(make(arm));
    adaptive_ = std::move(
        *AdaptiveFactory::Make(options, std::move(backends), {make, cores}, &sink_, clock));
  }

  // Runs one frame, whose searches must find the pairs of brute force.
  void Frame() {
    adaptive_->BeginFrame();
    ASSERT_NO_FATAL_FAILURE(Search(object_count_));
    for (const size_t count : substeps_) ASSERT_NO_FATAL_FAILURE(Search(count));
    adaptive_->EndFrame({.frame_time_ns = frame_time_ns_});
  }

  void Search(size_t object_count) {
    const std::span<const Aabb> boxes = scene_.boxes().first(object_count);
    const std::span<const OverlapPair> found = adaptive_->FindPairs(boxes);
    const std::vector<OverlapPair> right = ScalarPairs(boxes);
    ASSERT_EQ(PairDifference(found, right), "") << adaptive_->arms()[adaptive_->active_arm()];
    ASSERT_TRUE(!is_sorted_ || std::equal(found.begin(), found.end(), right.begin()));
    scene_.Step();
  }

  // Runs frames until the arm is active or the test takes too long.
  void SwitchTo(uint32_t arm) {
    adaptive_->mailbox().Post({.command_id = ++command_id_, .arm = arm});
    for (int frame = 0; frame < 100'000 && adaptive_->active_arm() != arm; ++frame) {
      Frame();
      if (HasFatalFailure()) return;
      std::this_thread::yield();
    }
    ASSERT_EQ(adaptive_->active_arm(), arm);
  }

  RecordingSink sink_;
  BoxScene scene_{"brownian", 220, 3};
  uint32_t arm_count_ = static_cast<uint32_t>(BroadPhaseNames().size());
  size_t object_count_ = 200;
  bool is_sorted_ = false;         // whether the pairs must be sorted, too
  std::vector<size_t> substeps_;   // object counts of further searches per frame
  uint64_t frame_time_ns_ = 1000;  // so short that no preparation is late
  uint64_t command_id_ = 0;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(WarmSwitchTest, FindsAllPairsDuringSwitchesBetweenAllArms) {
  Make({});
  const auto arm_count = static_cast<uint32_t>(adaptive_->arms().size());
  uint64_t switches = 0;
  for (uint32_t step = 1; step < arm_count; ++step) {
    for (uint32_t i = 0; i < arm_count; ++i) {
      ASSERT_NO_FATAL_FAILURE(SwitchTo((adaptive_->active_arm() + step) % arm_count));
      ++switches;
      for (int frame = 0; frame < 3; ++frame) ASSERT_NO_FATAL_FAILURE(Frame());
    }
  }
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, switches);
  EXPECT_EQ(adaptive_->shadow_stats().cold_switch_count, 0U);
  for (const FrameSample& sample : sink_.frames) {
    EXPECT_EQ(sample.flags & kFrameRebuild, sample.frame_index == 0 ? 1U : 0U);
  }
}

TEST_F(WarmSwitchTest, FindsAllPairsWhileTheObjectCountChanges) {
  Make({});
  for (uint32_t round = 0; round < 14; ++round) {
    object_count_ = 60 + 37 * round % 160;
    ASSERT_NO_FATAL_FAILURE(SwitchTo((round + 1) % 7));
    for (int frame = 0; frame < 5; ++frame) {
      object_count_ = 60 + (object_count_ * 7 + 11) % 160;
      ASSERT_NO_FATAL_FAILURE(Frame());
    }
  }
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 14U);
}

// Switches by hand and by commands that the lane prepares, with searches divided on an executor.
// The results do not depend on the arm.
TEST_F(WarmSwitchTest, SortedPairsAreTheSameBytesWithEveryArm) {
  LoneExecutor executor;
  scene_ = BoxScene("brownian", 1000, 3);
  object_count_ = 1000;
  is_sorted_ = true;
  Make({.executor = &executor, .sorted_pairs = true});
  for (const uint32_t step : {1U, 3U}) {
    for (uint32_t i = 0; i < 7; ++i) {
      const uint32_t arm = (adaptive_->active_arm() + step) % 7;
      if (i % 3 == 0) {
        ASSERT_TRUE(adaptive_->SelectArm(adaptive_->arms()[arm]).ok());
      }
      ASSERT_NO_FATAL_FAILURE(SwitchTo(arm));
      for (int frame = 0; frame < 3; ++frame) ASSERT_NO_FATAL_FAILURE(Frame());
    }
  }
  EXPECT_GT(executor.call_count, 0);
  adaptive_.reset();
}

TEST_F(WarmSwitchTest, TheLaneMeasuresTheFirstOfSeveralSearches) {
  frame_time_ns_ = 16 * kMs;  // long enough to copy frames often
  substeps_ = {150, 220};
  Make({.shadow = {.duty_ratio = 1, .sweep_interval_min_ns = 0}});
  while (adaptive_->shadow_stats().sweep_count < 2) {
    ASSERT_NO_FATAL_FAILURE(Frame());
    std::this_thread::yield();
  }
  frame_time_ns_ = 1000;
  for (uint32_t arm = 1; arm < 7; ++arm) ASSERT_NO_FATAL_FAILURE(SwitchTo(arm));
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 6U);
  EXPECT_LE(adaptive_->shadow_stats().copied_frame_count, sink_.frames.size());
  adaptive_.reset();
  for (const ShadowSample& sample : sink_.shadows) EXPECT_EQ(sample.object_count, 200U);
  for (const FrameSample& sample : sink_.frames) EXPECT_EQ(sample.object_count, 220U);
}

TEST_F(WarmSwitchTest, ReportsNoRebuildForAWarmSwitch) {
  Make({.settling_ns = 20'000});
  ASSERT_NO_FATAL_FAILURE(SwitchTo(3));
  for (int frame = 0; frame < 50; ++frame) ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_EQ(sink_.switches.size(), 1U);
  EXPECT_EQ(sink_.switches[0].executed, 1U);
  EXPECT_EQ(sink_.switches[0].arm, 3U);
  EXPECT_EQ(sink_.switches[0].rebuild_time_ns, 0U);
}

TEST_F(WarmSwitchTest, SwitchesColdWithADeciderThatDoesNotUseTheLane) {
  Make({});
  ASSERT_NO_FATAL_FAILURE(SwitchTo(1));
  adaptive_->SetLaneUse(false);
  EXPECT_EQ(adaptive_->shadow_stats().state, ShadowState::kPaused);
  ASSERT_NO_FATAL_FAILURE(SwitchTo(2));
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 1U);
  EXPECT_EQ(adaptive_->shadow_stats().cold_switch_count, 1U);
  adaptive_->SetLaneUse(true);
  ASSERT_NO_FATAL_FAILURE(SwitchTo(3));
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 2U);
}

TEST_F(WarmSwitchTest, SwitchesWarmWithoutUseOfTheLaneIfTheGameRequestsIt) {
  Make({.shadow = {.enabled = ShadowMode::kOn}});
  adaptive_->SetLaneUse(false);
  ASSERT_NO_FATAL_FAILURE(SwitchTo(1));
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 1U);
}

TEST_F(WarmSwitchTest, SwitchesColdWhenThePreparationIsLate) {
  Make({});
  frame_time_ns_ = 600 * kMs;
  ASSERT_NO_FATAL_FAILURE(Frame());
  adaptive_->mailbox().Post({.command_id = 1, .arm = 2});
  ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->active_arm(), 2U);
}

// The lane needs more frames than have run when the process continues.
TEST_F(WarmSwitchTest, AStopOfTheProcessDoesNotMakeAPreparationLate) {
  test_support::ScriptedClock clock;
  clock.ReportCpu();
  Make({}, Cores<8>, clock);
  ASSERT_NO_FATAL_FAILURE(Frame());
  const uint32_t first_arm = adaptive_->active_arm();
  const uint32_t next_arm = (first_arm + 1) % arm_count_;
  adaptive_->mailbox().Post({.command_id = ++command_id_, .arm = next_arm});
  adaptive_->BeginFrame();
  ASSERT_NO_FATAL_FAILURE(Search(object_count_));
  clock.AdvanceWaiting(2'000 * kMs);
  adaptive_->EndFrame({.frame_time_ns = 2'000 * kMs});
  EXPECT_EQ(adaptive_->last_sample().flags, uint32_t{kFrameSuspended});
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->active_arm(), first_arm) << "the command still waits";
  ASSERT_NO_FATAL_FAILURE(SwitchTo(next_arm));
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 1U);
  EXPECT_EQ(adaptive_->shadow_stats().cold_switch_count, 0U);
}

TEST_F(WarmSwitchTest, BailOutsAndManualSelectionsDoNotWait) {
  Make({});
  ASSERT_NO_FATAL_FAILURE(Frame());
  adaptive_->mailbox().Post({.command_id = 1, .arm = 2, .reason = SwitchReason::kBailOut});
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->active_arm(), 2U);
  ASSERT_TRUE(adaptive_->SelectArm("DBVT").ok());
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->arms()[adaptive_->active_arm()], "DBVT");
  EXPECT_EQ(adaptive_->shadow_stats().cold_switch_count, 2U);
}

TEST_F(WarmSwitchTest, SwitchesAtOnceIfAFrameExceedsTheBailOutLimit) {
  Make({.bail_out_ns = 100 * kMs});
  adaptive_->SetDeciderPresent(true);
  adaptive_->mailbox().Post({.command_id = 1, .arm = 2});
  frame_time_ns_ = 101 * kMs;
  ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->active_arm(), 2U);
}

TEST_F(WarmSwitchTest, ALaterCommandReplacesAWaitingOne) {
  Make({});
  ASSERT_NO_FATAL_FAILURE(Frame());
  adaptive_->mailbox().Post({.command_id = 77, .arm = 2});
  ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_EQ(adaptive_->active_arm(), 0U);
  ASSERT_NO_FATAL_FAILURE(SwitchTo(4));
  EXPECT_EQ(adaptive_->switch_epoch(), 1U);
}

TEST_F(WarmSwitchTest, AChangeOfModeOrArmRefusesAWaitingCommand) {
  Make({});
  ASSERT_NO_FATAL_FAILURE(Frame());
  adaptive_->mailbox().Post({.command_id = 5, .arm = 2});
  ASSERT_NO_FATAL_FAILURE(Frame());
  adaptive_->SetMode(Mode::kManual);
  ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_EQ(sink_.switches.size(), 1U);
  EXPECT_EQ(sink_.switches[0].command_id, 5U);
  EXPECT_EQ(sink_.switches[0].executed, 0U);
  adaptive_->SetMode(Mode::kAi);
  adaptive_->mailbox().Post({.command_id = 6, .arm = 2});
  ASSERT_NO_FATAL_FAILURE(Frame());
  ASSERT_TRUE(adaptive_->SelectArm(adaptive_->arms()[2]).ok());
  ASSERT_NO_FATAL_FAILURE(Frame());
  EXPECT_EQ(adaptive_->active_arm(), 2U);
  EXPECT_EQ(sink_.switches.back().command_id, 6U);
  EXPECT_EQ(sink_.switches.back().executed, 0U);
}

TEST_F(WarmSwitchTest, HasNoLaneWithoutNeedOrASpareCore) {
  const auto state = [this] { return adaptive_->shadow_stats().state; };
  Make({.shadow = {.enabled = ShadowMode::kOff}});
  EXPECT_EQ(state(), ShadowState::kOff);
  Make({}, Cores<1>);
  EXPECT_EQ(state(), ShadowState::kNoSpareCore);
  LoneExecutor executor;
  Make({.executor = &executor}, Cores<2>);
  EXPECT_EQ(state(), ShadowState::kNoSpareCore);
  ASSERT_NO_FATAL_FAILURE(SwitchTo(3));
  EXPECT_EQ(adaptive_->shadow_stats().cold_switch_count, 1U);
  Make({.mode = Mode::kManual});
  EXPECT_EQ(state(), ShadowState::kPaused);
  Make({.mode = Mode::kManual, .shadow = {.enabled = ShadowMode::kOn}});
  EXPECT_EQ(state(), ShadowState::kRunning);
  auto alone = AdaptiveBroadPhase::Create({.arms = {"SAP"}}, nullptr);
  ASSERT_TRUE(alone.ok());
  EXPECT_EQ((*alone)->shadow_stats().state, ShadowState::kOneArm);
}

TEST_F(WarmSwitchTest, UsesTheExecutorOnlyOnTheFrameThread) {
  LoneExecutor executor;
  // Two arms are enough for this test. More arms would make each sweep longer, and on a busy
  // machine the lane gets little time.
  arm_count_ = 2;
  scene_ = BoxScene("brownian", 1500, 3);
  Make({.executor = &executor, .shadow = {.duty_ratio = 1, .sweep_interval_min_ns = 0}});
  const auto frame = [this] {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(scene_.boxes());
    // This is long enough for the lane to copy frames often, and short enough for the switch to
    // wait for the lane.
    adaptive_->EndFrame({.frame_time_ns = kMs});
    // The lane's thread runs only on idle cores, so leave it some time.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  for (const uint32_t arm : {1U, 0U}) {
    adaptive_->mailbox().Post({.command_id = arm, .arm = arm});
    while (adaptive_->active_arm() != arm) frame();
    // Run frames until the lane has visited the backend that it received in exchange for the
    // prepared backend.
    const uint64_t sweep_count = adaptive_->shadow_stats().sweep_count;
    while (adaptive_->shadow_stats().sweep_count < sweep_count + 2) frame();
  }
  EXPECT_EQ(adaptive_->shadow_stats().warm_switch_count, 2U);
  const int calls_before = executor.call_count;  // Brute force uses the executor in every frame.
  frame();
  EXPECT_GT(executor.call_count, calls_before);
  adaptive_.reset();
}

TEST_F(WarmSwitchTest, CanBeDestroyedWhileTheLaneWorks) {
  frame_time_ns_ = 16 * kMs;
  for (int round = 0; round < 20; ++round) {
    Make({.shadow = {.duty_ratio = 1, .sweep_interval_min_ns = 0}});
    for (int frame = 0; frame < 2 * round; ++frame) ASSERT_NO_FATAL_FAILURE(Frame());
    if (round % 2 == 0) adaptive_->mailbox().Post({.command_id = 1, .arm = 2});
    ASSERT_NO_FATAL_FAILURE(Frame());
    adaptive_.reset();
  }
}

TEST_F(WarmSwitchTest, TheLaneSendsSamplesOfEveryArm) {
  frame_time_ns_ = 16 * kMs;  // long enough to copy frames often
  Make({.shadow = {.duty_ratio = 1, .sweep_interval_min_ns = 0}});
  while (adaptive_->shadow_stats().sweep_count < 3) {
    ASSERT_NO_FATAL_FAILURE(Frame());
    std::this_thread::yield();
  }
  const uint64_t visit_count = adaptive_->shadow_stats().visit_count;
  adaptive_.reset();
  ASSERT_GE(sink_.shadows.size(), visit_count);
  for (uint32_t arm = 0; arm < 7; ++arm) {
    EXPECT_TRUE(std::any_of(sink_.shadows.begin(), sink_.shadows.end(),
                            [arm](const ShadowSample& sample) { return sample.arm == arm; }));
  }
  for (const ShadowSample& sample : sink_.shadows) {
    EXPECT_LT(sample.first_frame_index, sink_.frames.size());
    EXPECT_EQ(sample.object_count, 200U);
    EXPECT_GT(sample.detection_time_ns, 0U);
    EXPECT_GT(sample.build_time_ns, 0U);
    EXPECT_GT(sample.native_bytes, 0U);
    const uint32_t active = sink_.frames[sample.first_frame_index].arm;
    EXPECT_EQ((sample.flags & kShadowActive) != 0, sample.arm == active);
  }
}

}  // namespace
}  // namespace sweepstake
