#include "engine_client/decider/policy/regime_memory.h"

#include <gtest/gtest.h>

namespace sweepstake::decision {
namespace {

SceneDescriptor Moving(double speed, double object_count = 1'000, double static_ratio = 0) {
  SceneDescriptor descriptor;
  descriptor.object_count = static_cast<float>(object_count);
  descriptor.speed_mean = static_cast<float>(speed);
  descriptor.static_ratio = static_cast<float>(static_ratio);
  return descriptor;
}

TEST(RegimeMemory, RecognisesAReturningRegime) {
  RegimeMemory memory;
  const uint32_t rest = memory.Observe(Moving(0.001)).regime;
  memory.Observe(Moving(0.0011));
  const auto motion = memory.Observe(Moving(0.1));
  EXPECT_TRUE(motion.is_new);
  EXPECT_NE(motion.regime, rest);
  EXPECT_FALSE(memory.Observe(Moving(0.09)).is_new);
  const auto back = memory.Observe(Moving(0.0009));
  EXPECT_FALSE(back.is_new);
  EXPECT_EQ(back.regime, rest);
}

TEST(RegimeMemory, DistinguishesRegimesByCountAndStaticShareToo) {
  RegimeMemory memory;
  memory.Observe(Moving(0.1));
  memory.Observe(Moving(0.1));
  EXPECT_TRUE(memory.Observe(Moving(0.1, 3'000)).is_new);
  memory.Observe(Moving(0.1, 3'000));
  EXPECT_TRUE(memory.Observe(Moving(0.1, 3'000, 0.5)).is_new);
}

TEST(RegimeMemory, SamplingNoiseOfADescriptorMakesNoNewRegime) {
  RegimeMemory memory;
  memory.Observe(Moving(3.2, 1'000, 0.66));
  memory.Observe(Moving(3.2, 1'000, 0.66));
  for (const double speed : {1.6, 4.9, 2.5, 4.0, 1.7}) {
    EXPECT_FALSE(memory.Observe(Moving(speed, 1'000, 0.66 + 0.05 * (speed - 3))).is_new) << speed;
  }
}

TEST(RegimeMemory, AnUnmeasuredPropertyMatchesOnlyItself) {
  RegimeMemory memory;
  memory.Observe(Moving(0.1));
  memory.Observe(Moving(0.1));
  SceneDescriptor count_alone;
  count_alone.object_count = 1'000;
  EXPECT_TRUE(memory.Observe(count_alone).is_new);
  EXPECT_FALSE(memory.Observe(count_alone).is_new);
  EXPECT_FALSE(memory.Observe(Moving(0.1)).is_new);
}

TEST(RegimeMemory, MatchesDescriptorsWithoutAssigningThem) {
  RegimeMemory memory;
  EXPECT_EQ(memory.Match(Moving(0.001)), DescriptorMatch::kPresent);
  memory.Observe(Moving(0.001));
  EXPECT_EQ(memory.Match(Moving(0.1)), DescriptorMatch::kUnknown);
  EXPECT_EQ(memory.Match(Moving(0.1)), DescriptorMatch::kUnknown);
  memory.Observe(Moving(0.1));
  EXPECT_EQ(memory.Match(Moving(0.1)), DescriptorMatch::kPresent);
  EXPECT_EQ(memory.Match(Moving(0.001)), DescriptorMatch::kOther);
}

TEST(RegimeMemory, ForgetsTheLeastRecentRegime) {
  RegimeMemory memory;
  double speed = 0.001;
  for (uint32_t i = 0; i < RegimeMemory::kMaxRegimes; ++i, speed *= 10) {
    memory.Observe(Moving(speed));
    memory.Observe(Moving(speed));
  }
  EXPECT_FALSE(memory.Observe(Moving(0.001)).is_new);
  const auto fifth = memory.Observe(Moving(speed));
  EXPECT_TRUE(fifth.is_new);
  EXPECT_EQ(fifth.regime, 1u);
  EXPECT_FALSE(memory.Observe(Moving(0.001)).is_new);
}

}  // namespace
}  // namespace sweepstake::decision
