// A frame during which the process was stopped is flagged, and changes no decision of the client.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::kMs;
using test_support::RecordingSink;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;

constexpr uint64_t kStopNs = 6'000 * kMs;
constexpr uint64_t kRestNs = 10 * kMs;  // a frame's time without the search

// Runs three scripted arms on a clock with CPU times.
class SuspensionTest : public ::testing::Test {
 protected:
  void SetUp() override { Make({}); }

  void Make(const AdaptiveOptions& options) {
    clock_.ReportCpu();
    std::vector<std::unique_ptr<BroadPhase>> backends;
    arms_.clear();
    for (const char* name : {"A", "B", "C"}) {
      const ArmScript script{.name = name, .build_ns = 3 * kMs, .update_ns = kMs, .find_ns = kMs};
      auto backend = std::make_unique<ScriptedBroadPhase>(script, clock_);
      arms_.push_back(backend.get());
      backends.push_back(std::move(backend));
    }
    sink_ = RecordingSink();
    adaptive_ = std::move(*AdaptiveFactory::Make(options, std::move(backends), &sink_, clock_));
  }

  const FrameSample& Frame() {
    const uint64_t begin_ns = clock_.NowNs();
    adaptive_->BeginFrame();
    adaptive_->FindPairs(std::vector<Aabb>(4));
    clock_.Advance(kRestNs);
    adaptive_->EndFrame({.frame_time_ns = clock_.NowNs() - begin_ns});
    return adaptive_->last_sample();
  }
  const FrameSample& StoppedFrame() {
    ArmScript& script = arms_[adaptive_->active_arm()]->script();
    script.stopped_ns = kStopNs;
    Frame();
    script.stopped_ns = 0;
    return adaptive_->last_sample();
  }
  const FrameSample& SlowFrame() {
    ArmScript& script = arms_[adaptive_->active_arm()]->script();
    const uint64_t ordinary_ns = std::exchange(script.find_ns, kStopNs);
    Frame();
    script.find_ns = ordinary_ns;
    return adaptive_->last_sample();
  }

  ScriptedClock clock_;
  RecordingSink sink_;
  std::vector<ScriptedBroadPhase*> arms_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(SuspensionTest, AStopIsFlaggedAndIsNoBailOut) {
  Frame();
  EXPECT_EQ(StoppedFrame().flags, uint32_t{kFrameSuspended});
  EXPECT_EQ(adaptive_->last_sample().detection_time_ns, kStopNs + 2 * kMs)
      << "the sample contains the measured times";
  EXPECT_EQ(Frame().flags, 0U);
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
  ASSERT_EQ(sink_.frames.size(), 3U) << "the frame counts as a frame";
  EXPECT_EQ(sink_.frames[1].flags, uint32_t{kFrameSuspended});
}

TEST_F(SuspensionTest, ASlowArmIsABailOutAsBefore) {
  Frame();
  EXPECT_EQ(SlowFrame().flags, uint32_t{kFrameBailOut});
  EXPECT_EQ(Frame().arm, 1U);
}

TEST_F(SuspensionTest, AStopBetweenSearchesIsFlaggedToo) {
  Frame();
  const uint64_t begin_ns = clock_.NowNs();
  adaptive_->BeginFrame();
  adaptive_->FindPairs(std::vector<Aabb>(4));
  clock_.AdvanceWaiting(kStopNs);
  adaptive_->EndFrame({.frame_time_ns = clock_.NowNs() - begin_ns});
  EXPECT_EQ(adaptive_->last_sample().flags, uint32_t{kFrameSuspended});
}

TEST_F(SuspensionTest, AStopDoesNotEndTheModeOfAnOrder) {
  adaptive_->Obey({.order_id = 1, .mode = Mode::kManual, .arm = 1});
  Frame();
  StoppedFrame();
  EXPECT_EQ(adaptive_->mode(), Mode::kManual);
  SlowFrame();
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
}

TEST_F(SuspensionTest, AStopIsNoPartOfTheCostOfASwitch) {
  Make({.settling_ns = 100 * kMs});
  for (int frame = 0; frame < 5; ++frame) Frame();
  adaptive_->mailbox().Post({.command_id = 1, .arm = 1});
  arms_[1]->script().stopped_ns = kStopNs;
  EXPECT_EQ(Frame().flags, uint32_t{kFrameRebuild | kFrameSuspended});
  arms_[1]->script().stopped_ns = 0;
  Frame();
  StoppedFrame();
  for (int frame = 0; frame < 20; ++frame) Frame();
  ASSERT_EQ(sink_.switches.size(), 1U);
  EXPECT_EQ(sink_.switches[0].rebuild_time_ns, 0U);
  EXPECT_EQ(sink_.switches[0].settling_cost_ns, 0U);
}

TEST_F(SuspensionTest, AFrozenGameReadsNoClock) {
  adaptive_->Freeze();
  const uint64_t before = clock_.reading_count();
  adaptive_->BeginFrame();
  adaptive_->FindPairs(std::vector<Aabb>(4));
  clock_.AdvanceWaiting(kStopNs);
  adaptive_->EndFrame({.frame_time_ns = kStopNs});
  EXPECT_EQ(clock_.reading_count(), before);
  EXPECT_EQ(adaptive_->last_sample().flags & kFrameSuspended, 0U);
}

// Runs the parts of a search on this thread, as if two threads ran them.
class TwoThreads final : public Executor {
 public:
  size_t thread_count() const noexcept override { return 2; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }
};

// The frame thread waits for other threads, which compute for six seconds.
TEST_F(SuspensionTest, AParallelSearchThatComputesForLongIsABailOut) {
  TwoThreads executor;
  for (const bool is_parallel : {false, true}) {
    Make({.executor = is_parallel ? &executor : nullptr});
    adaptive_->SetDeciderPresent(true);
    Frame();
    arms_[0]->script().waiting_ns = kStopNs;
    EXPECT_EQ(Frame().flags, uint32_t{is_parallel ? kFrameBailOut : kFrameSuspended});
    arms_[0]->script().waiting_ns = 0;
    EXPECT_EQ(StoppedFrame().flags, uint32_t{kFrameSuspended});
  }
}

}  // namespace
}  // namespace sweepstake
