#include "engine_client/decider/policy/reward.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sweepstake::decision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

FpsReference ReferenceOf(std::initializer_list<double> windows) {
  FpsReference reference;
  for (const double fps : windows) reference.Add(fps);
  return reference;
}

double Sum(const RewardWeights& w) { return w.fps + w.detection + w.memory + w.checks; }

TEST(FpsReference, QuantilesInterpolateBetweenOrderStatistics) {
  const FpsReference reference = ReferenceOf({50, 10, 40, 20, 30});
  EXPECT_DOUBLE_EQ(reference.Quantile(0), 10);
  EXPECT_DOUBLE_EQ(reference.Quantile(1), 50);
  EXPECT_DOUBLE_EQ(reference.Quantile(0.5), 30);
  EXPECT_DOUBLE_EQ(reference.Quantile(0.05), 12);
  EXPECT_DOUBLE_EQ(reference.Quantile(0.95), 48);
}

TEST(FpsReference, KeepsTheLastThirtyWindows) {
  FpsReference reference;
  for (int i = 0; i < 5; ++i) reference.Add(1'000);
  for (int i = 0; i < 29; ++i) reference.Add(60);
  EXPECT_DOUBLE_EQ(reference.Quantile(1), 1'000);
  reference.Add(60);
  EXPECT_DOUBLE_EQ(reference.Quantile(1), 60);
}

TEST(FpsScore, IsRelativeToTheRecentRange) {
  // The score is 1 at hi = Q95 = 97.5, and 0 at lo = min(Q05, hi / 2) = min(52.5, 48.75).
  const FpsReference reference = ReferenceOf({50, 75, 100});
  EXPECT_DOUBLE_EQ(reference.Score(48.75), 0);
  EXPECT_DOUBLE_EQ(reference.Score(97.5), 1);
  EXPECT_DOUBLE_EQ(reference.Score(73.125), 0.5);
}

TEST(FpsScore, JudgesASlowRunAgainstThirtyFramesPerSecond) {
  // hi = 30, lo = min(Q05, hi / 2) = min(10, 15). A run with only 10 FPS does not get the full
  // score.
  const FpsReference reference = ReferenceOf({10, 10, 10});
  EXPECT_DOUBLE_EQ(reference.Score(10), 0);
  EXPECT_DOUBLE_EQ(reference.Score(20), 0.5);
}

TEST(FpsScore, LowEndIsAtMostHalfOfTheHighEnd) {
  const FpsReference reference = ReferenceOf({100, 100, 100});
  EXPECT_DOUBLE_EQ(reference.Score(75), 0.5);
}

TEST(FpsScore, IsClampedToTheUnitInterval) {
  const FpsReference reference = ReferenceOf({60});
  EXPECT_EQ(reference.Score(1e9), 1);
  EXPECT_EQ(reference.Score(6), 0);
}

TEST(FpsScore, IsZeroNearStallWhateverTheReference) {
  const FpsReference reference = ReferenceOf({1, 1, 1, 1});  // hi = 30, lo = 1
  EXPECT_EQ(reference.Score(4.999), 0);
  EXPECT_GT(reference.Score(5), 0);
}

TEST(DetectionScore, FallsLinearlyToZeroAtOneFrameOfSixtyHertz) {
  const FpsReference reference = ReferenceOf({60});
  EXPECT_DOUBLE_EQ(Score({.fps = 60, .detection_ms = 0}, reference).detection, 1);
  EXPECT_DOUBLE_EQ(Score({.fps = 60, .detection_ms = 16.67 / 4}, reference).detection, 0.75);
  EXPECT_EQ(Score({.fps = 60, .detection_ms = 16.67}, reference).detection, 0);
  EXPECT_EQ(Score({.fps = 60, .detection_ms = 1e300}, reference).detection, 0);
}

TEST(MemoryScore, FallsLinearlyToZeroAtSixtyFourMebibytes) {
  const FpsReference reference = ReferenceOf({60});
  EXPECT_DOUBLE_EQ(Score({.fps = 60, .native_mib = 16}, reference).memory, 0.75);
  EXPECT_EQ(Score({.fps = 60, .native_mib = 64}, reference).memory, 0);
  EXPECT_EQ(Score({.fps = 60, .native_mib = 1e12}, reference).memory, 0);
}

TEST(CheckScore, FallsLinearlyToZeroAtAllPairs) {
  const FpsReference reference = ReferenceOf({60});
  EXPECT_DOUBLE_EQ(Score({.fps = 60, .check_ratio = 0.25}, reference).checks, 0.75);
  EXPECT_EQ(Score({.fps = 60, .check_ratio = 40}, reference).checks, 0);
}

TEST(Weights, AreTheConfiguredOnesFromTwentyFiveFpsOn) {
  const RewardWeights weights = WeightsAt({}, 25);
  EXPECT_EQ(weights.fps, 0.55);
  EXPECT_EQ(weights.detection, 0.25);
  EXPECT_EQ(weights.memory, 0.12);
  EXPECT_EQ(weights.checks, 0.08);
}

TEST(Weights, FpsRisesLinearlyAndTheOthersShrinkInProportionUnderTwentyFiveFps) {
  const RewardWeights half = WeightsAt({}, 12.5);
  EXPECT_DOUBLE_EQ(half.fps, 0.70);
  EXPECT_DOUBLE_EQ(half.detection, 0.25 * 0.30 / 0.45);
  EXPECT_DOUBLE_EQ(half.memory, 0.12 * 0.30 / 0.45);
  EXPECT_DOUBLE_EQ(half.checks, 0.08 * 0.30 / 0.45);
  EXPECT_NEAR(Sum(half), 1, 1e-15);
}

TEST(Weights, FpsCountsEightyFivePercentAtZeroFps) {
  const RewardWeights stalled = WeightsAt({}, 0);
  EXPECT_DOUBLE_EQ(stalled.fps, 0.85);
  EXPECT_NEAR(Sum(stalled), 1, 1e-15);
}

TEST(Weights, NeverFallIfTheConfiguredFpsWeightIsHigher) {
  const RewardWeights only_fps{.fps = 1, .detection = 0, .memory = 0, .checks = 0};
  EXPECT_EQ(WeightsAt(only_fps, 3).fps, 1);
  EXPECT_EQ(WeightsAt(only_fps, 3).detection, 0);
}

TEST(Reward, IsTheWeightedSumOfTheScores) {
  const FpsReference reference = ReferenceOf({100, 100});
  const WindowMetrics metrics{
      .fps = 75, .detection_ms = 16.67 / 2, .native_mib = 48, .check_ratio = 0.75};
  EXPECT_NEAR(*Reward(metrics, reference, {}), 0.55 * 0.5 + 0.25 * 0.5 + 0.12 * 0.25 + 0.08 * 0.25,
              1e-15);
}

TEST(Reward, StaysInTheUnitIntervalAtBothEnds) {
  const FpsReference reference = ReferenceOf({100});
  EXPECT_LE(*Reward({.fps = 1e9}, reference, {}), 1);
  EXPECT_NEAR(*Reward({.fps = 1e9}, reference, {}), 1, 1e-15);
  EXPECT_EQ(*Reward({.fps = 1e-12, .detection_ms = 1e13, .native_mib = 1e13, .check_ratio = 1e19},
                    reference, {}),
            0);
}

TEST(Reward, IsAbsentIfAMetricIsNotFinite) {
  const FpsReference reference = ReferenceOf({100});
  const double nan = std::nan("");
  EXPECT_FALSE(Reward({.fps = kInfinity}, reference, {}));
  EXPECT_FALSE(Reward({.fps = nan}, reference, {}));
  EXPECT_FALSE(Reward({.fps = 60, .detection_ms = nan}, reference, {}));
  EXPECT_FALSE(Reward({.fps = 60, .native_mib = kInfinity}, reference, {}));
  EXPECT_FALSE(Reward({.fps = 60, .check_ratio = nan}, reference, {}));
}

}  // namespace
}  // namespace sweepstake::decision
