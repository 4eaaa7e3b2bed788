#include "engine_client/adaptive/guards/bail_out_guard.h"

#include <gtest/gtest.h>

#include <limits>

namespace sweepstake {
namespace {

constexpr uint64_t kLimitNs = 5'000'000'000;

// Returns a frame over the limit, with three quarters of its time in detection.
FrameSample LongFrame(uint32_t arm) {
  FrameSample sample{};
  sample.arm = arm;
  sample.frame_time_ns = 8'000'000'000;
  sample.detection_time_ns = 6'000'000'000;
  return sample;
}

TEST(BailOutGuard, CountsOnlyFramesOverTheLimit) {
  const BailOutGuard guard(kLimitNs, 3);
  EXPECT_FALSE(guard.Exceeds(kLimitNs));
  EXPECT_TRUE(guard.Exceeds(kLimitNs + 1));
}

TEST(BailOutGuard, AcceptsANewLimitExceptZero) {
  BailOutGuard guard(kLimitNs, 3);
  guard.SetLimit(10);
  guard.SetLimit(0);
  EXPECT_FALSE(guard.Exceeds(10));
  EXPECT_TRUE(guard.Exceeds(11));
}

TEST(BailOutGuard, ChoosesTheNextArmInOrderWithoutASnapshot) {
  const BailOutGuard guard(kLimitNs, 3);
  EXPECT_EQ(guard.LocalChoice(LongFrame(0)), 1U);
  EXPECT_EQ(guard.LocalChoice(LongFrame(2)), 0U);
}

TEST(BailOutGuard, ChoosesTheHighestMeanAmongTheOtherArms) {
  BailOutGuard guard(kLimitNs, 4);
  guard.SetPosteriorMeans(std::vector<double>{0.9, 0.2, 0.7, 0.3});
  EXPECT_EQ(guard.LocalChoice(LongFrame(0)), 2U);
  EXPECT_EQ(guard.LocalChoice(LongFrame(2)), 0U);
}

TEST(BailOutGuard, IgnoresASnapshotOfAnotherLengthOrWithNaN) {
  BailOutGuard guard(kLimitNs, 3);
  guard.SetPosteriorMeans(std::vector<double>{0.1, 0.9});
  guard.SetPosteriorMeans(std::vector<double>{0.1, std::numeric_limits<double>::quiet_NaN(), 0.9});
  EXPECT_EQ(guard.LocalChoice(LongFrame(0)), 1U);
}

TEST(BailOutGuard, DoesNotChooseIfADeciderIsConnected) {
  BailOutGuard guard(kLimitNs, 3);
  guard.SetDeciderPresent(true);
  EXPECT_FALSE(guard.LocalChoice(LongFrame(0)).has_value());
  guard.SetDeciderPresent(false);
  EXPECT_TRUE(guard.LocalChoice(LongFrame(0)).has_value());
}

TEST(BailOutGuard, IgnoresFramesWithDetectionUnderHalfOfTheTime) {
  const BailOutGuard guard(kLimitNs, 2);
  FrameSample sample = LongFrame(0);
  sample.detection_time_ns = sample.frame_time_ns / 2;
  EXPECT_TRUE(guard.LocalChoice(sample).has_value());
  --sample.detection_time_ns;
  EXPECT_FALSE(guard.LocalChoice(sample).has_value());
}

TEST(BailOutGuard, IgnoresFramesWithoutCost) {
  const BailOutGuard guard(kLimitNs, 2);
  for (const uint32_t flag : {kFramePaused, kFrameLoading, kFrameSuspended, kFramePairsExceeded}) {
    FrameSample sample = LongFrame(0);
    sample.flags = flag;
    EXPECT_FALSE(guard.LocalChoice(sample).has_value());
  }
}

TEST(BailOutGuard, DoesNotChooseIfThereIsOnlyOneArm) {
  const BailOutGuard guard(kLimitNs, 1);
  EXPECT_FALSE(guard.LocalChoice(LongFrame(0)).has_value());
}

}  // namespace
}  // namespace sweepstake
