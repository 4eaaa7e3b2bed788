// What the frame path must not do in a steady scene: allocate, or call anything that could make it
// wait.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "engine_client/telemetry/sample_queue.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/box_scenes.h"
#include "tests/support/malloc_counter.h"
#include "tests/support/wait_counter.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::ThreadAllocationCount;
using test_support::ThreadMallocCount;
using test_support::WaitCounter;

constexpr int kWarmUpFrames = 600;
constexpr int kMeasuredFrames = 300;

// Takes everything off the queue until told to stop, as a sender does.
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
    auto made = AdaptiveBroadPhase::Create(options, &queue_);
    ASSERT_TRUE(made.ok()) << made.status().message();
    adaptive_ = std::move(*made);
    for (int frame = 0; frame < kWarmUpFrames; ++frame) {
      RunFrame(*adaptive_, scene_);
      scene_.Step();
    }
  }

  SampleQueue queue_{256};  // Full most of the time where nobody drains it.
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

TEST_P(FramePathCost, CallsNothingThatCouldWaitWithOrWithoutAReader) {
  for (int frame = 0; frame < kMeasuredFrames; ++frame) {
    std::unique_ptr<Drain> drain;
    if (frame % 30 == 0) drain = std::make_unique<Drain>(queue_);
    const WaitCounter waits;
    RunFrame(*adaptive_, scene_);
    ASSERT_EQ(waits.count(), 0U) << waits.last_call();
  }
}

INSTANTIATE_TEST_SUITE_P(EveryArm, FramePathCost,
                         ::testing::Values("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT",
                                           "Tracy", "KDTree"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST(WaitCounterTest, SeesLocksSleepsAndFutexes) {
  if (!WaitCounter::Works()) GTEST_SKIP() << "not with ThreadSanitizer";
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

TEST(MallocCounterTest, SeesMallocReallocAndNew) {
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
