#include "engine_client/adaptive/box_tap.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sweepstake {
namespace {

std::vector<Aabb> Boxes(size_t count, float at) {
  return std::vector<Aabb>(count, Aabb{{at, at, at}, {at + 1, at + 1, at + 1}});
}

// A clock that advances by 1 ns with each reading.
class TickingClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override { return ++now_ns_; }
  uint64_t now_ns() const { return now_ns_; }

 private:
  uint64_t now_ns_ = 0;
};

class BoxTapTest : public ::testing::Test {
 protected:
  void Frame(uint64_t index, size_t count) {
    tap_.OnFrame(Boxes(count, static_cast<float>(index)),
                 {.frame_index = index, .frame_time_ns = 10 * index, .arm = 2}, clock_);
  }

  TickingClock clock_;
  BoxTap tap_;
};

TEST_F(BoxTapTest, CopiesNothingAndReadsNoClockWithoutARequest) {
  tap_.Reserve(4, 100);
  for (uint64_t index = 0; index < 5; ++index) Frame(index, 10);
  EXPECT_EQ(tap_.filled_count(), 0U);
  EXPECT_EQ(clock_.now_ns(), 0U);
  EXPECT_EQ(tap_.latest_frame_index(), 4U);
}

TEST_F(BoxTapTest, CopiesConsecutiveFramesAndNoMoreThanRequested) {
  tap_.Reserve(4, 100);
  Frame(6, 10);
  tap_.Request(3);
  EXPECT_FALSE(tap_.complete());
  for (uint64_t index = 7; index < 12; ++index) Frame(index, index);
  EXPECT_TRUE(tap_.complete());
  ASSERT_EQ(tap_.filled_count(), 3U);
  for (uint32_t slot = 0; slot < 3; ++slot) {
    const TappedFrame frame = tap_.frame(slot);
    EXPECT_EQ(frame.note.frame_index, 7U + slot);
    EXPECT_EQ(frame.note.frame_time_ns, 70U + 10 * slot);
    EXPECT_EQ(frame.note.arm, 2U);
    EXPECT_EQ(frame.copy_time_ns, 1U);
    const std::vector<Aabb> expected = Boxes(7 + slot, static_cast<float>(7 + slot));
    EXPECT_EQ(std::vector<Aabb>(frame.boxes.begin(), frame.boxes.end()), expected);
  }
}

TEST_F(BoxTapTest, EndsTheRequestAtAFrameThatDoesNotFitAndReportsItsSize) {
  tap_.Reserve(4, 100);
  tap_.Request(4);
  Frame(1, 100);
  Frame(2, 101);
  Frame(3, 50);
  EXPECT_TRUE(tap_.complete());
  EXPECT_EQ(tap_.filled_count(), 1U);
  EXPECT_EQ(tap_.too_big_count(), 101U);
  tap_.Reserve(4, 200);
  EXPECT_EQ(tap_.memory_bytes(), 4 * 200 * sizeof(Aabb));
  tap_.Request(1);
  Frame(4, 101);
  EXPECT_EQ(tap_.filled_count(), 1U);
  EXPECT_EQ(tap_.too_big_count(), 0U);
}

TEST_F(BoxTapTest, CopiesFramesWithoutBoxes) {
  tap_.Reserve(1, 0);
  tap_.Request(1);
  Frame(1, 0);
  EXPECT_EQ(tap_.filled_count(), 1U);
  EXPECT_TRUE(tap_.frame(0).boxes.empty());
}

// ThreadSanitizer reports a slot that two threads own at the same time.
TEST(BoxTapThreads, CopiesCompleteFramesWhileTheGameRuns) {
  BoxTap tap;
  tap.Reserve(BoxTap::kMaxSlots, 200);
  std::atomic<bool> stop{false};
  std::thread game([&] {
    TickingClock clock;
    for (uint64_t index = 1; !stop.load(); ++index) {
      tap.OnFrame(Boxes(index % 200, static_cast<float>(index % 1000)), {.frame_index = index},
                  clock);
    }
  });
  for (uint32_t round = 0; round < 300; ++round) {
    const uint32_t wanted = 1 + round % BoxTap::kMaxSlots;
    tap.Request(wanted);
    while (!tap.complete()) std::this_thread::yield();
    ASSERT_EQ(tap.filled_count(), wanted);
    const uint64_t first = tap.frame(0).note.frame_index;
    for (uint32_t slot = 0; slot < wanted; ++slot) {
      const TappedFrame frame = tap.frame(slot);
      ASSERT_EQ(frame.note.frame_index, first + slot);
      ASSERT_EQ(frame.boxes.size(), (first + slot) % 200);
      for (const Aabb& box : frame.boxes) {
        ASSERT_EQ(box.min[1], static_cast<float>((first + slot) % 1000));
      }
    }
  }
  stop.store(true);
  game.join();
}

}  // namespace
}  // namespace sweepstake
