#include "engine_client/telemetry/common/flight_ring.h"

#include <gtest/gtest.h>

#include <vector>

namespace sweepstake {
namespace {

constexpr uint64_t kMs = 1'000'000;
constexpr uint64_t kBudgetNs = 50 * kMs;

// A game in which box `object` of a frame has the coordinate frame · 100 + object.
class FlightRingTest : public ::testing::Test {
 protected:
  static Aabb BoxOf(uint64_t frame, size_t object) {
    const auto at = static_cast<float>(frame * 100 + object);
    return {{at, at, at}, {at + 1, at + 1, at + 1}};
  }

  void Frame(FlightRing& ring, uint64_t frame_ms, size_t count = 4, uint32_t flags = 0) {
    std::vector<Aabb> boxes;
    for (size_t object = 0; object < count; ++object) boxes.push_back(BoxOf(next_, object));
    if (count > 0) ring.OnBoxes(boxes);
    ring.OnFrame({.frame_index = next_++,
                  .frame_time_ns = frame_ms * kMs,
                  .detection_time_ns = 0,
                  .aabb_check_count = 0,
                  .native_bytes = 0,
                  .pair_count = 0,
                  .object_count = static_cast<uint32_t>(count),
                  .arm = 0,
                  .switch_epoch = 0,
                  .flags = flags,
                  .invalid_box_count = 0});
  }

  void Frames(FlightRing& ring, size_t frames, size_t count = 4) {
    for (size_t i = 0; i < frames; ++i) Frame(ring, 10, count);
  }

  // Returns the frames with boxes, and checks that the boxes are those of the game.
  static size_t CheckedBoxFrames(const FlightRing& ring) {
    size_t found = 0;
    for (const FlightFrame& frame : ring.Frames()) {
      for (uint32_t object = 0; object < frame.box_count; ++object)
        EXPECT_EQ(ring.BoxOf(frame, object), BoxOf(frame.sample.frame_index, object));
      if (frame.box_count > 0) ++found;
    }
    return found;
  }

  uint64_t next_ = 0;
};

TEST_F(FlightRingTest, FreezesAFrameOverTheBudgetWithTheFiveSecondsBefore) {
  FlightRing ring(10'000, kBudgetNs);
  Frames(ring, 1000);
  EXPECT_FALSE(ring.frozen());
  Frame(ring, 51);
  ASSERT_TRUE(ring.frozen());
  const std::vector<FlightFrame> frames = ring.Frames();
  EXPECT_EQ(frames.back().sample.frame_index, 1000U);
  EXPECT_EQ(frames.front().sample.frame_index, 505U);  // 495 · 10 ms + 51 ms are over five seconds
  EXPECT_EQ(frames.size(), 496U);
  EXPECT_EQ(CheckedBoxFrames(ring), 496U);
  Frame(ring, 10);
  EXPECT_EQ(ring.Frames().back().sample.frame_index, 1000U);
  EXPECT_EQ(ring.latest_frame_index(), 1001U);
}

TEST_F(FlightRingTest, DoesNotFreezeForFramesWithinTheBudgetPausedOrLoading) {
  FlightRing ring(10'000, kBudgetNs);
  Frames(ring, 200);
  Frame(ring, 50);
  Frame(ring, 5000, 4, kFramePaused);
  Frame(ring, 5000, 4, kFrameLoading);
  Frame(ring, 5000, 4, kFrameSuspended);
  EXPECT_FALSE(ring.frozen());
  Frame(ring, 51, 4, kFrameRebuild);
  EXPECT_TRUE(ring.frozen());
}

TEST_F(FlightRingTest, KeepsBoxesAtEqualIntervalsIfFiveSecondsDoNotFit) {
  FlightRing ring(40, kBudgetNs);
  Frames(ring, 1008);  // keeps ten copies of boxes in five seconds, the last one in frame 1000
  Frame(ring, 51, 0);
  EXPECT_FALSE(ring.frozen());
  Frame(ring, 10);  // The frame over the budget has no boxes, this frame has.
  ASSERT_TRUE(ring.frozen());
  const std::vector<FlightFrame> frames = ring.Frames();
  EXPECT_EQ(frames.back().box_count, 4U);
  EXPECT_EQ(frames[frames.size() - 2].sample.frame_time_ns, 51 * kMs);
  EXPECT_EQ(CheckedBoxFrames(ring), 10U) << "the eleventh copy replaced the oldest";
}

TEST_F(FlightRingTest, KeepsNoBoxesIfTwoFramesDoNotFit) {
  FlightRing ring(7, kBudgetNs);
  Frames(ring, 200);
  Frame(ring, 51);
  EXPECT_FALSE(ring.frozen());
  Frame(ring, 10);
  ASSERT_TRUE(ring.frozen());
  EXPECT_EQ(CheckedBoxFrames(ring), 0U);
  EXPECT_EQ(ring.Frames().size(), 202U);
}

TEST_F(FlightRingTest, ReplacesTheOldestBoxesIfObjectCountsChange) {
  FlightRing ring(50, kBudgetNs);
  for (size_t i = 0; i < 2000; ++i) Frame(ring, 10, i % 25 + 1);
  Frame(ring, 51, 25);
  for (int more = 0; more < 2 && !ring.frozen(); ++more) Frame(ring, 10, 25);
  ASSERT_TRUE(ring.frozen());
  EXPECT_GE(CheckedBoxFrames(ring), 2U);
  EXPECT_EQ(ring.Frames().back().box_count, 25U);
}

TEST_F(FlightRingTest, ReplacesTheOldestFramesWhenFull) {
  FlightRing ring(10'000, kBudgetNs);
  for (size_t i = 0; i < 3 * FlightRing::kFrames; ++i) Frame(ring, 1);
  Frame(ring, 51);
  ASSERT_TRUE(ring.frozen());
  EXPECT_EQ(ring.Frames().size(), FlightRing::kFrames);
}

TEST_F(FlightRingTest, DoesNotFreezeInTheFirstSecondAndTheCooldown) {
  FlightRing ring(10'000, kBudgetNs);
  Frame(ring, 900);
  EXPECT_FALSE(ring.frozen());
  Frame(ring, 100);
  ASSERT_TRUE(ring.frozen());
  ring.Release();
  Frames(ring, 2990);
  Frame(ring, 51);
  EXPECT_FALSE(ring.frozen());
  Frames(ring, 10);
  Frame(ring, 51);
  ASSERT_TRUE(ring.frozen());
  EXPECT_EQ(ring.Frames().size(), 492U);
  EXPECT_EQ(CheckedBoxFrames(ring), 492U);
}

// The sender may release the ring at any time, also between a frame's boxes and its end.
TEST_F(FlightRingTest, AReleaseWithinAFrameDropsTheBoxesOfThatFrame) {
  FlightRing ring(10'000, kBudgetNs);
  Frames(ring, 200);
  Frame(ring, 51);
  ASSERT_TRUE(ring.frozen());
  const std::vector<Aabb> boxes(4);
  ring.OnBoxes(boxes);
  ring.Release();
  Frame(ring, 10, 0);
  Frame(ring, 31'000);
  ASSERT_TRUE(ring.frozen());
  const std::vector<FlightFrame> frames = ring.Frames();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].box_count, 4U);
}

}  // namespace
}  // namespace sweepstake
