#include "engine_client/decider/policy/regime_beliefs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sweepstake::decision {
namespace {

SceneDescriptor DescriptorOf(double speed) {
  SceneDescriptor descriptor;
  descriptor.object_count = 1'000;
  descriptor.speed_mean = static_cast<float>(speed);
  return descriptor;
}

// The first arm costs 10 µs at rest and 60 µs in motion, the second one always 20 µs.
void Learn(RegimeBeliefs& beliefs, bool rests) {
  beliefs.filter().ObserveLive(0, std::log(rests ? 10.0 : 60.0));
  beliefs.filter().ObserveLive(1, std::log(20.0));
}

bool ObserveTick(RegimeBeliefs& beliefs, bool rests) {
  const bool changed = beliefs.Observe(DescriptorOf(rests ? 0.001 : 1), /*intervals=*/1);
  Learn(beliefs, rests);
  return changed;
}

RegimeBeliefs AfterRegimesOf(int ticks_each) {
  RegimeBeliefs beliefs{RelativeCostFilter(2)};
  for (int tick = 0; tick < 20 * ticks_each; ++tick)
    ObserveTick(beliefs, tick / ticks_each % 2 == 0);
  return beliefs;
}

TEST(RegimeBeliefs, AreThoseOfThePresentRegime) {
  RegimeBeliefs beliefs = AfterRegimesOf(10);
  EXPECT_TRUE(ObserveTick(beliefs, true));
  EXPECT_FALSE(ObserveTick(beliefs, true));
  EXPECT_LT(beliefs.Difference(0, 1).mean, -0.5);
  EXPECT_EQ(beliefs.LogCost(0).mean, beliefs.filter().LogCost(0).mean);
  EXPECT_EQ(beliefs.Covariance(0, 1), beliefs.filter().Covariance(0, 1));
  EXPECT_TRUE(ObserveTick(beliefs, false));
  EXPECT_GT(beliefs.Difference(0, 1).mean, 0.5);
}

TEST(RegimeBeliefs, DistinguishAChangingSceneFromAConstantOne) {
  RegimeBeliefs beliefs{RelativeCostFilter(2)};
  for (int tick = 0; tick < 20; ++tick) ObserveTick(beliefs, true);
  EXPECT_FALSE(beliefs.scene_changes());
  ObserveTick(beliefs, false);
  EXPECT_TRUE(beliefs.scene_changes());
  for (int tick = 0; tick < 20; ++tick) ObserveTick(beliefs, true);
  EXPECT_TRUE(beliefs.scene_changes());
}

// A choice that is made in one regime takes effect only in the next one.
TEST(RegimeBeliefs, AreAMixtureIfRegimesChangeFasterThanChoices) {
  RegimeBeliefs beliefs = AfterRegimesOf(2);
  for (const bool rests : {true, false, true, false}) {
    EXPECT_TRUE(ObserveTick(beliefs, rests));
    const double first = std::log((10.0 + 60) / 2);
    EXPECT_NEAR(beliefs.LogCost(0).mean, first, 0.25);
    EXPECT_NEAR(beliefs.Difference(0, 1).mean, first - std::log(20), 0.3);
    EXPECT_GT(beliefs.Difference(0, 1).variance, 0);
    EXPECT_LT(beliefs.Difference(0, 1).variance, 0.1);
  }
}

TEST(RegimeBeliefs, FollowRegimesAgainOnceTheyLastLonger) {
  RegimeBeliefs beliefs = AfterRegimesOf(2);
  EXPECT_GT(beliefs.Difference(0, 1).mean, 0.1) << "the beliefs are a mixture";
  for (int tick = 0; tick < 20; ++tick) ObserveTick(beliefs, true);
  EXPECT_LT(beliefs.Difference(0, 1).mean, -0.5);
}

}  // namespace
}  // namespace sweepstake::decision
