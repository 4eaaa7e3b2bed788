#include "engine_client/telemetry/protocol/evidence_intake.h"

#include <gtest/gtest.h>

#include "engine_client/telemetry/protocol/wire.h"

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
          .invalid_box_count = 0};
}

TEST(FrameBatcher, CollectsFrames) {
  FrameBatcher batcher({});
  batcher.Add(FrameOf(0), 0);
  batcher.Add(FrameOf(1), 1);
  const protocol::FrameBatch batch = batcher.Take();
  ASSERT_EQ(batch.frames.size(), 2U);
  EXPECT_EQ(batch.frames[1].frame_time_ns, 16'000'001U);
  EXPECT_FALSE(batch.scene_descriptor);
  EXPECT_TRUE(batcher.empty());
}

constexpr ShadowSample kVisit = {.first_frame_index = 4,
                                 .detection_time_ns = 30'000,
                                 .build_time_ns = 90'000,
                                 .aabb_check_count = 777,
                                 .native_bytes = 4096,
                                 .arm = 3,
                                 .object_count = 1000,
                                 .frame_count = 5,
                                 .flags = kShadowActive};

TEST(FrameBatcher, SendsVisitsOfTheShadowLaneWithTheFrames) {
  FrameBatcher batcher({});
  batcher.AddShadow(kVisit);
  EXPECT_TRUE(batcher.empty());
  batcher.Add(FrameOf(0), 0);
  const protocol::FrameBatch batch = batcher.Take();
  ASSERT_EQ(batch.shadow_samples.size(), 1U);
  EXPECT_EQ(batch.shadow_samples[0].detection_time_ns, 30'000U);
  batcher.Add(FrameOf(1), 0);
  EXPECT_EQ(batcher.Take().shadow_samples.size(), 0U);
}

TEST(FrameBatcher, LimitsVisitsToSixtyFourAndHalfOfTheBytes) {
  FrameBatcher batcher({.interval_ns = 1'000'000, .frames = 240, .bytes = 256 * 1024});
  for (; batcher.TakesShadow(); batcher.AddShadow(kVisit)) {
  }
  batcher.Add(FrameOf(0), 0);
  EXPECT_EQ(batcher.Take().shadow_samples.size(), 64U);
  EXPECT_TRUE(batcher.TakesShadow());

  batcher.SetLimits({.interval_ns = 1'000'000, .frames = 240, .bytes = 1024});
  ShadowSample large = kVisit;
  large.first_frame_index = large.detection_time_ns = large.build_time_ns = ~uint64_t{0};
  large.aabb_check_count = large.native_bytes = ~uint64_t{0};
  for (; batcher.TakesShadow(); batcher.AddShadow(large)) {
  }
  uint64_t index = 0;
  for (; batcher.Fits(FrameOf(index)); ++index) batcher.Add(FrameOf(index), 0);
  const protocol::FrameBatch batch = batcher.Take();
  EXPECT_GT(batch.shadow_samples.size(), 2U);
  EXPECT_GT(batch.frames.size(), 10U);
  EXPECT_LE(protocol::Encode(batch).size(), 1024U);
}

TEST(FrameBatcher, SendsTheLargestCountOfInvalidBoxes) {
  FrameBatcher batcher({});
  for (const uint32_t count : {0U, 5U, 2U}) {
    FrameSample sample = FrameOf(count == 0 ? 0 : count == 5 ? 1 : 2);
    sample.invalid_box_count = count;
    batcher.Add(sample, 0);
  }
  EXPECT_EQ(batcher.Take().invalid_box_count, 5U);
  batcher.Add(FrameOf(3), 0);
  EXPECT_EQ(batcher.Take().invalid_box_count, 0U);
}

TEST(FrameBatcher, IsDueAfterTheInterval) {
  FrameBatcher batcher({.interval_ns = 100, .frames = 30, .bytes = 16384});
  EXPECT_FALSE(batcher.Due(1000));
  batcher.Add(FrameOf(0), 1000);
  EXPECT_FALSE(batcher.Due(1099));
  EXPECT_TRUE(batcher.Due(1100));
}

TEST(FrameBatcher, IsDueWithTheMaximumNumberOfFrames) {
  FrameBatcher batcher({.interval_ns = 1'000'000, .frames = 3, .bytes = 16384});
  for (uint64_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(batcher.Due(0));
    EXPECT_TRUE(batcher.Fits(FrameOf(i)));
    batcher.Add(FrameOf(i), 0);
  }
  EXPECT_TRUE(batcher.Due(0));
  EXPECT_FALSE(batcher.Fits(FrameOf(3)));
}

TEST(FrameBatcher, StaysWithinTheMaximumBytes) {
  FrameBatcher batcher({.interval_ns = 1'000'000, .frames = 240, .bytes = 600});
  uint64_t index = 0;
  while (batcher.Fits(FrameOf(index))) batcher.Add(FrameOf(index++), 0);
  EXPECT_GT(index, 10U);
  EXPECT_LT(index, 240U);
  batcher.SetDescriptor({1, 1, 1, 1, 1, 1, 1});
  EXPECT_LE(protocol::Numbered(~uint64_t{0}, protocol::Encode(batcher.Take())).size(), 600U);
}

TEST(FrameBatcher, AGapInFrameNumbersBeginsABatchAndCountsAsDropped) {
  FrameBatcher batcher({});
  batcher.Add(FrameOf(5), 0);
  EXPECT_EQ(batcher.Take().dropped_frame_count, 5U);
  batcher.Add(FrameOf(6), 0);
  EXPECT_FALSE(batcher.Fits(FrameOf(10)));
  EXPECT_EQ(batcher.Take().dropped_frame_count, 0U);
  batcher.Add(FrameOf(10), 0);
  const protocol::FrameBatch batch = batcher.Take();
  EXPECT_EQ(batch.dropped_frame_count, 3U);
}

TEST(FrameBatcher, SendsTheLatestDescriptor) {
  FrameBatcher batcher({});
  SceneDescriptor descriptor;
  descriptor.object_count = 10;
  batcher.SetDescriptor(descriptor);
  descriptor.object_count = 20;
  descriptor.static_ratio = 0;
  batcher.SetDescriptor(descriptor);
  EXPECT_TRUE(batcher.empty());
  batcher.Add(FrameOf(0), 0);
  const SceneDescriptor sent = *batcher.Take().scene_descriptor;
  EXPECT_EQ(sent.object_count, 20);
  EXPECT_EQ(sent.static_ratio, 0);
}

}  // namespace
}  // namespace sweepstake
