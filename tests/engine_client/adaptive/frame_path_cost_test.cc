// In a steady scene the frame path must not allocate, and must not call anything that could block.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/view_tap.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/malloc_counter.h"
#include "tests/support/wait_counter.h"

namespace sweepstake {
namespace {

using test_support::ThreadAllocationCount;
using test_support::ThreadMallocCount;
using test_support::WaitCounter;

constexpr int kWarmUpFrames = 600;
constexpr int kMeasuredFrames = 300;

// Empties the queue until it is stopped, like a sender.
class Drain {
 public:
  explicit Drain(SampleQueue& queue)
      : thread_([this, &queue] {
          while (!stop_.load(std::memory_order_relaxed)) {
            while (queue.Pop()) {
            }
            std::this_thread::yield();
          }
        }) {}
  ~Drain() {
    stop_.store(true, std::memory_order_relaxed);
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

void RunFrame(AdaptiveBroadPhase& adaptive, BoxScene& scene) {
  adaptive.BeginFrame();
  adaptive.FindPairs(scene.boxes());
  adaptive.EndFrame({.frame_time_ns = 16'666'667});
}

class FramePathCost : public ::testing::TestWithParam<std::string_view> {
 protected:
  void SetUp() override {
    AdaptiveOptions options;
    options.arms = {std::string(GetParam())};
    options.sorted_pairs = true;
    auto made = AdaptiveBroadPhase::Create(options, &queue_);
    ASSERT_TRUE(made.ok()) << made.status().message();
    adaptive_ = std::move(*made);
    for (int frame = 0; frame < kWarmUpFrames; ++frame) {
      RunFrame(*adaptive_, scene_);
      scene_.Step();
    }
  }

  const std::shared_ptr<FlightRing> ring_ =
      std::make_shared<FlightRing>(5000, /*budget_ns=*/20'000'000);
  SampleQueue queue_{256, ring_};  // Full most of the time without a Drain.
  BoxScene scene_{"brownian", 500, 11};
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_P(FramePathCost, AllocatesNothingAfterWarmUp) {
  uint64_t allocation_count = 0;
  uint64_t malloc_count = 0;
  for (int frame = 0; frame < kMeasuredFrames; ++frame) {
    const uint64_t allocations_before = ThreadAllocationCount();
    const uint64_t mallocs_before = ThreadMallocCount();
    RunFrame(*adaptive_, scene_);
    allocation_count += ThreadAllocationCount() - allocations_before;
    malloc_count += ThreadMallocCount() - mallocs_before;
    scene_.Step();
  }
  EXPECT_EQ(allocation_count, 0U);
  EXPECT_EQ(malloc_count, 0U);
}

TEST_P(FramePathCost, AllocatesNothingAndNeverBlocksWithABoxView) {
  ViewTap& tap = adaptive_->view_tap();
  for (const size_t max_boxes : {100U, 1000U}) {
    tap.Request(max_boxes);
    const uint64_t before = ThreadAllocationCount() + ThreadMallocCount();
    {
      const WaitCounter waits;
      RunFrame(*adaptive_, scene_);
      EXPECT_EQ(waits.count(), 0U) << waits.last_call();
    }
    EXPECT_EQ(ThreadAllocationCount() + ThreadMallocCount() - before, 0U);
    ASSERT_TRUE(tap.has_frame());
    EXPECT_EQ(tap.frame().boxes.size(), std::min<size_t>(max_boxes, 500));
    scene_.Step();
  }
}

TEST_P(FramePathCost, AllocatesNothingAndNeverBlocksWithAFlightRecorder) {
  for (int frame = 0; frame < kMeasuredFrames; ++frame) {
    const uint64_t before = ThreadAllocationCount() + ThreadMallocCount();
    {
      const WaitCounter waits;
      adaptive_->BeginFrame();
      adaptive_->FindPairs(scene_.boxes());
      adaptive_->EndFrame({.frame_time_ns = frame == 100 ? 20'000'001U : 16'666'667U});
      ASSERT_EQ(waits.count(), 0U) << waits.last_call();
    }
    ASSERT_EQ(ThreadAllocationCount() + ThreadMallocCount() - before, 0U);
    scene_.Step();
  }
  ASSERT_TRUE(ring_->frozen());
  EXPECT_EQ(ring_->Frames().back().box_count, 500U);
}

TEST_P(FramePathCost, NeverBlocksWithOrWithoutAReader) {
  for (int frame = 0; frame < kMeasuredFrames; ++frame) {
    std::unique_ptr<Drain> drain;
    if (frame % 30 == 0) drain = std::make_unique<Drain>(queue_);
    const WaitCounter waits;
    RunFrame(*adaptive_, scene_);
    ASSERT_EQ(waits.count(), 0U) << waits.last_call();
  }
}

// A clock that goes on by 1 ns per reading, and at one of them by a second.
class JumpingClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    now_ns_ += jumps_in_ > 0 && --jumps_in_ == 0 ? 1'000'000'000 : 1;
    return now_ns_;
  }
  void JumpAtReading(int number) { jumps_in_ = number; }

 private:
  uint64_t now_ns_ = 1;
  int jumps_in_ = 0;
};

// Both arms were active before, so that their buffers have their full size.
TEST_P(FramePathCost, AllocatesNothingAndNeverBlocksWhenATrialIsStopped) {
  const std::string former = GetParam() == "SAP" ? "KDTree" : "SAP";
  JumpingClock clock;
  auto adaptive = std::move(*AdaptiveBroadPhase::Create({.arms = {former, std::string(GetParam())},
                                                         .shadow = {.enabled = ShadowMode::kOff},
                                                         .sorted_pairs = true},
                                                        &queue_, clock));
  for (const char* const arm : {former.c_str(), GetParam().data(), former.c_str()}) {
    ASSERT_TRUE(adaptive->SelectArm(arm).ok());
    for (int frame = 0; frame < 20; ++frame) RunFrame(*adaptive, scene_);
  }
  adaptive->mailbox().Post({.arm = 1, .trial_limit_percent = 120});
  for (int frame = 0; frame < 10; ++frame) RunFrame(*adaptive, scene_);
  ASSERT_EQ(adaptive->active_arm(), 1U);
  clock.JumpAtReading(2);
  const uint64_t before = ThreadAllocationCount() + ThreadMallocCount();
  {
    const WaitCounter waits;
    RunFrame(*adaptive, scene_);
    EXPECT_EQ(waits.count(), 0U) << waits.last_call();
  }
  EXPECT_EQ(ThreadAllocationCount() + ThreadMallocCount() - before, 0U);
  EXPECT_EQ(adaptive->last_sample().arm, 0U);
  EXPECT_EQ(adaptive->last_outcome()->trial_arm, 1U);
}

INSTANTIATE_TEST_SUITE_P(EveryArm, FramePathCost,
                         ::testing::Values("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT",
                                           "Tracy", "KDTree"),
                         [](const auto& arm) { return std::string(arm.param); });

// All arms, with a lane that works without pauses.
std::unique_ptr<AdaptiveBroadPhase> MakeWithLane(FrameSink& sink) {
  const auto make = [](uint32_t arm) {
    return ArmBackend{nullptr, std::move(*MakeBroadPhase(BroadPhaseNames()[arm]))};
  };
  std::vector<ArmBackend> backends;
  for (uint32_t arm = 0; arm < BroadPhaseNames().size(); ++arm) backends.push_back(make(arm));
  const AdaptiveOptions options{.shadow = {.duty_ratio = 1, .sweep_interval_min_ns = 0}};
  return std::move(*AdaptiveFactory::Make(
      options, std::move(backends),
      {.make = make, .usable_cores = []() noexcept { return size_t{8}; }}, &sink, SteadyClock()));
}

// Counts allocations and waits, which must not occur on the frame thread.
struct Faults {
  uint64_t allocation_count = 0;
  uint64_t wait_count = 0;

  void AddFrame(AdaptiveBroadPhase& adaptive, std::span<const Aabb> boxes, uint64_t frame_time_ns) {
    const uint64_t before = ThreadAllocationCount() + ThreadMallocCount();
    {
      const WaitCounter waits;
      adaptive.BeginFrame();
      adaptive.FindPairs(boxes);
      adaptive.EndFrame({.frame_time_ns = frame_time_ns});
      wait_count += waits.count();
    }
    allocation_count += ThreadAllocationCount() + ThreadMallocCount() - before;
  }
};

// The scene is at rest, because in a moving scene a structure may need more memory at any time.
TEST(FramePathCostWithLane, AllocatesNothingAndNeverBlocksInSweepsAndWarmSwitches) {
  SampleQueue queue(256);
  const BoxScene scene("brownian", 500, 11);
  // With long frames the lane copies frames often. With short frames every switch waits until the
  // lane has prepared it.
  constexpr uint64_t kLongFrameNs = 16'000'000;
  constexpr uint64_t kShortFrameNs = 1000;
  const auto adaptive = MakeWithLane(queue);
  Faults faults;
  faults.AddFrame(*adaptive, scene.boxes(), kLongFrameNs);
  faults = Faults();
  while (adaptive->shadow_stats().sweep_count < 20) {
    faults.AddFrame(*adaptive, scene.boxes(), kLongFrameNs);
    std::this_thread::yield();
  }
  for (uint32_t step = 1; step <= 21; ++step) {
    const uint32_t arm = (adaptive->active_arm() + 1 + step / 7) % 7;
    adaptive->mailbox().Post({.command_id = step, .arm = arm});
    while (adaptive->active_arm() != arm) {
      faults.AddFrame(*adaptive, scene.boxes(), kShortFrameNs);
      std::this_thread::yield();
    }
    for (int i = 0; i < 10; ++i) faults.AddFrame(*adaptive, scene.boxes(), kShortFrameNs);
  }
  EXPECT_EQ(adaptive->shadow_stats().warm_switch_count, 21U);
  EXPECT_GT(adaptive->shadow_stats().copied_frame_count, 100U);
  EXPECT_EQ(faults.allocation_count, 0U);
  EXPECT_EQ(faults.wait_count, 0U);
}

TEST(WaitCounterTest, CountsLocksSleepsAndFutexes) {
  if (!WaitCounter::Works()) GTEST_SKIP() << "the counter does not work with ThreadSanitizer";
  std::mutex mutex;
  std::atomic<int> word{1};
  {
    const WaitCounter waits;
    mutex.lock();
    mutex.unlock();
    EXPECT_EQ(waits.count(), 1U);
    std::this_thread::sleep_for(std::chrono::nanoseconds(1));
    EXPECT_EQ(waits.count(), 2U);
    std::thread changer([&word] {
      word.store(2);
      word.notify_one();
    });
    word.wait(1);
    changer.join();
    EXPECT_GE(waits.count(), 3U);
  }
  const WaitCounter fresh;
  EXPECT_EQ(fresh.count(), 0U);
}

TEST(MallocCounterTest, CountsMallocReallocAndNew) {
  const uint64_t before = ThreadMallocCount();
  PairBuffer pairs;
  pairs.Append({0, 1});
  EXPECT_EQ(ThreadMallocCount(), before + 1);
  const auto number = std::make_unique<int>(1);
  EXPECT_EQ(ThreadMallocCount(), before + 2);
  EXPECT_EQ(*number, 1);
}

}  // namespace
}  // namespace sweepstake
