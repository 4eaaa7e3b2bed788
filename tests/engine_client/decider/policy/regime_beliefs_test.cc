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
  const bool changed = beliefs.Observe(DescriptorOf(rests ? 0.001 : 1));
  Learn(beliefs, rests);
  return changed;
}

TEST(RegimeBeliefs, AreThoseOfThePresentRegime) {
  RegimeBeliefs beliefs{RelativeCostFilter(2)};
  for (int tick = 0; tick < 100; ++tick) ObserveTick(beliefs, tick / 10 % 2 == 0);
  EXPECT_TRUE(ObserveTick(beliefs, true));
  EXPECT_FALSE(ObserveTick(beliefs, true));
  EXPECT_LT(beliefs.filter().Difference(0, 1).mean, -0.5);
  EXPECT_TRUE(ObserveTick(beliefs, false));
  EXPECT_GT(beliefs.filter().Difference(0, 1).mean, 0.5);
  EXPECT_EQ(beliefs.change_count(), 11u);
}

}  // namespace
}  // namespace sweepstake::decision
