#include "tests/laboratory/policies/baselines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

TEST(PooledVariance, IsThatWithinTheArmsNotBetweenThem) {
  RandomStream random(1, RandomPurpose::kChoice, 0, 0);
  PooledVariance variance(3);
  for (uint32_t i = 0; i < 3'000; ++i)
    variance.Add(i % 3, 4.0 * (i % 3) + 0.1 * DrawNormal(random));
  EXPECT_NEAR(variance.value(), 0.01, 0.001);
}

TEST(PooledVariance, IsInflatedWhereWindowsResembleTheOneBefore) {
  RandomStream random(1, RandomPurpose::kChoice, 0, 0);
  PooledVariance variance(1);
  double state = 0;
  for (int i = 0; i < 20'000; ++i) {
    state = 0.5 * state + 0.1 * DrawNormal(random);
    variance.Add(0, state);
  }
  EXPECT_NEAR(variance.value(), 0.04, 0.004);  // 0.1² ÷ (1 − 0.5)²
}

TEST(CalibratedPolicy, SeparatesCloseArmsWithinMinutes) {
  SessionSetup setup = PlainSetup(3);
  setup.options.policy = "calibrated";
  setup.options.explore = true;
  ScriptedClient client(setup);
  RandomStream random(5, RandomPurpose::kChoice, 0, 0);
  int best = 0;
  for (int tick = 0; tick < 400; ++tick) {
    const double cost_ns = 1e6 * (client.arm == 1 ? 1.0 : 1.1) * (1 + 0.02 * DrawNormal(random));
    client.frame.detection_time_ns = static_cast<uint64_t>(cost_ns);
    client.RunToTick();
    if (tick >= 100 && client.arm == 1) ++best;
  }
  EXPECT_GE(best, 290);
}

TEST(CalibratedPolicy, ABailOutOutweighsTenWindows) {
  SessionSetup setup = PlainSetup(2);
  setup.options.policy = "calibrated";
  ScriptedClient client(setup);
  client.RunTicks(10);
  const double before = client.session.posteriors()[client.arm].mean();
  const FrameSample stall{.frame_time_ns = 6'000'000'000,
                          .detection_time_ns = 6'000'000'000,
                          .arm = client.arm,
                          .switch_epoch = client.epoch};
  client.session.ObserveBailOut(stall, client.now_ns);
  EXPECT_LT(client.session.posteriors()[client.arm].mean(), before / 1.8);
}

}  // namespace
}  // namespace sweepstake::decision
