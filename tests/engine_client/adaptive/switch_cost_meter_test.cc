#include "engine_client/adaptive/switch_cost_meter.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

FrameSample FrameOf(uint64_t frame_time_ns, uint32_t flags = 0) {
  FrameSample sample{};
  sample.frame_time_ns = frame_time_ns;
  sample.flags = flags;
  return sample;
}

TEST(SwitchCostMeter, ReportsNothingWithoutASwitch) {
  SwitchCostMeter meter(100);
  EXPECT_FALSE(meter.OnFrame(FrameOf(1000)).has_value());
}

TEST(SwitchCostMeter, SumsTheExcessOfTheFirstHalfOverTheMeanOfTheSecond) {
  SwitchCostMeter meter(100);
  EXPECT_FALSE(meter.Begin({.command_id = 7, .arm = 2}, 3).has_value());
  EXPECT_TRUE(meter.awaits_rebuild());
  meter.OnRebuild(5);
  EXPECT_FALSE(meter.awaits_rebuild());
  EXPECT_FALSE(meter.OnFrame(FrameOf(40)));  // first half: frames of 40 and 20 ns
  EXPECT_FALSE(meter.OnFrame(FrameOf(20)));
  EXPECT_FALSE(meter.OnFrame(FrameOf(10)));  // second half: mean of 10 ns
  EXPECT_FALSE(meter.OnFrame(FrameOf(10)));
  EXPECT_FALSE(meter.OnFrame(FrameOf(10)));
  const auto outcome = meter.OnFrame(FrameOf(10));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->command_id, 7U);
  EXPECT_EQ(outcome->arm, 2U);
  EXPECT_EQ(outcome->switch_epoch, 3U);
  EXPECT_EQ(outcome->executed, 1U);
  EXPECT_EQ(outcome->rebuild_time_ns, 5U);
  EXPECT_EQ(outcome->settling_cost_ns, (40U - 10U) + (20U - 10U));
  EXPECT_FALSE(meter.OnFrame(FrameOf(10)).has_value());
}

TEST(SwitchCostMeter, ReportsNoCostIfTheArmGetsSlower) {
  SwitchCostMeter meter(100);
  meter.Begin({.arm = 1}, 1);
  meter.OnFrame(FrameOf(50));
  const auto outcome = meter.OnFrame(FrameOf(60));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->settling_cost_ns, 0U);
}

TEST(SwitchCostMeter, WaitsForASettledFrameAfterALongOne) {
  SwitchCostMeter meter(100);
  meter.Begin({.arm = 1}, 1);
  EXPECT_FALSE(meter.OnFrame(FrameOf(1000)).has_value());
  const auto outcome = meter.OnFrame(FrameOf(10));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->settling_cost_ns, 990U);
}

TEST(SwitchCostMeter, IgnoresPausedAndLoadingFrames) {
  SwitchCostMeter meter(100);
  meter.Begin({.arm = 1}, 1);
  EXPECT_FALSE(meter.OnFrame(FrameOf(5000, kFramePaused)).has_value());
  EXPECT_FALSE(meter.OnFrame(FrameOf(5000, kFrameLoading)).has_value());
  EXPECT_FALSE(meter.OnFrame(FrameOf(5000, kFrameSuspended)).has_value());
  meter.OnFrame(FrameOf(60));
  const auto outcome = meter.OnFrame(FrameOf(40));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->settling_cost_ns, 20U);
}

TEST(SwitchCostMeter, ReportsASwitchThatAnotherOneInterrupts) {
  SwitchCostMeter meter(100);
  meter.Begin({.command_id = 1, .arm = 1}, 1);
  meter.OnFrame(FrameOf(10));
  const auto outcome = meter.Begin({.command_id = 2, .arm = 2}, 2);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->command_id, 1U);
  EXPECT_EQ(outcome->settling_cost_ns, 0U);
}

TEST(SwitchCostMeter, ReportsAtTheFirstFrameWithoutASettlingTime) {
  SwitchCostMeter meter(100);
  meter.SetSettling(0);
  meter.Begin({.arm = 1}, 1);
  EXPECT_TRUE(meter.OnFrame(FrameOf(10)).has_value());
}

TEST(SwitchCostMeter, ExpectsNoRebuildAfterAWarmSwitch) {
  SwitchCostMeter meter(100);
  meter.Begin({.command_id = 1, .arm = 1}, 1, /*warm=*/true);
  EXPECT_FALSE(meter.awaits_rebuild());
  meter.Begin({.command_id = 2, .arm = 2}, 2, /*warm=*/false);
  EXPECT_TRUE(meter.awaits_rebuild());
}

}  // namespace
}  // namespace sweepstake
