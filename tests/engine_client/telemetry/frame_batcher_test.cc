#include "engine_client/telemetry/frame_batcher.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

FrameSample FrameOf(uint64_t index) {
  return {.frame_index = index,
          .frame_time_ns = 16'000'000 + index,
          .detection_time_ns = 1'000'000 + index,
          .aabb_check_count = 5000,
          .native_bytes = 65536,
          .pair_count = 300,
          .object_count = 1000,
          .arm = 2,
          .switch_epoch = 7,
          .flags = kFrameRebuild,
          .reserved = 0};
}

TEST(FrameBatcher, PutsFramesIntoColumns) {
  FrameBatcher batcher({});
  batcher.Add(FrameOf(0), 0);
  batcher.Add(FrameOf(1), 1);
  const v1::FrameBatch batch = batcher.Take();
  EXPECT_EQ(batch.first_frame_index(), 0U);
  ASSERT_EQ(batch.frame_time_ns_size(), 2);
  EXPECT_EQ(batch.frame_time_ns(1), 16'000'001U);
  EXPECT_EQ(batch.detection_time_ns(1), 1'000'001U);
  EXPECT_EQ(batch.aabb_check_count(1), 5000U);
  EXPECT_EQ(batch.native_bytes(1), 65536U);
  EXPECT_EQ(batch.pair_count(1), 300U);
  EXPECT_EQ(batch.object_count(1), 1000U);
  EXPECT_EQ(batch.arm(1), 2U);
  EXPECT_EQ(batch.switch_epoch(1), 7U);
  EXPECT_EQ(batch.flags(1), uint32_t{kFrameRebuild});
  EXPECT_FALSE(batch.has_scene_descriptor());
  EXPECT_TRUE(batcher.empty());
}

TEST(FrameBatcher, IsDueAfterTheInterval) {
  FrameBatcher batcher({.interval_ns = 100, .frames = 30, .bytes = 16384});
  EXPECT_FALSE(batcher.Due(1000));
  batcher.Add(FrameOf(0), 1000);
  EXPECT_FALSE(batcher.Due(1099));
  EXPECT_TRUE(batcher.Due(1100));
}

TEST(FrameBatcher, IsDueWithTheMostFramesItTakes) {
  FrameBatcher batcher({.interval_ns = 1'000'000, .frames = 3, .bytes = 16384});
  for (uint64_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(batcher.Due(0));
    EXPECT_TRUE(batcher.Fits(FrameOf(i)));
    batcher.Add(FrameOf(i), 0);
  }
  EXPECT_TRUE(batcher.Due(0));
  EXPECT_FALSE(batcher.Fits(FrameOf(3)));
}

TEST(FrameBatcher, StaysWithinTheBytes) {
  FrameBatcher batcher({.interval_ns = 1'000'000, .frames = 240, .bytes = 600});
  uint64_t index = 0;
  while (batcher.Fits(FrameOf(index))) batcher.Add(FrameOf(index++), 0);
  EXPECT_GT(index, 10U);
  EXPECT_LT(index, 240U);
  batcher.SetDescriptor({1, 1, 1, 1, 1, 1, 1});
  v1::StreamTelemetryRequest request;
  request.set_sequence(~uint64_t{0});
  *request.mutable_frame_batch() = batcher.Take();
  EXPECT_LE(request.ByteSizeLong(), 600U);
}

TEST(FrameBatcher, ReportsAGapInTheNumbersAsDroppedAndBeginsABatchThere) {
  FrameBatcher batcher({});
  batcher.Add(FrameOf(5), 0);
  EXPECT_EQ(batcher.Take().dropped_frame_count(), 5U);
  batcher.Add(FrameOf(6), 0);
  EXPECT_FALSE(batcher.Fits(FrameOf(10)));
  EXPECT_EQ(batcher.Take().dropped_frame_count(), 0U);
  batcher.Add(FrameOf(10), 0);
  const v1::FrameBatch batch = batcher.Take();
  EXPECT_EQ(batch.first_frame_index(), 10U);
  EXPECT_EQ(batch.dropped_frame_count(), 3U);
}

TEST(FrameBatcher, SendsTheLatestDescriptorWithoutWhatWasNotMeasured) {
  FrameBatcher batcher({});
  SceneDescriptor descriptor;
  descriptor.object_count = 10;
  batcher.SetDescriptor(descriptor);
  descriptor.object_count = 20;
  descriptor.static_ratio = 0;
  batcher.SetDescriptor(descriptor);
  EXPECT_TRUE(batcher.empty());
  batcher.Add(FrameOf(0), 0);
  const v1::SceneDescriptor wire = batcher.Take().scene_descriptor();
  EXPECT_EQ(wire.object_count(), 20);
  EXPECT_TRUE(wire.has_static_ratio());
  EXPECT_FALSE(wire.has_speed_mean());
}

}  // namespace
}  // namespace sweepstake
