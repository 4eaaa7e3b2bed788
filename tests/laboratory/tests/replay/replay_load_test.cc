// Tests other work on the core of a replayed game's frame thread (ReplayLoad).
#include "tests/laboratory/replay/replay_run.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/laboratory/tests/replay/replay_fixtures.h"

namespace sweepstake::cli {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

// Returns the ratio in each of `seconds` seconds.
std::vector<double> RatiosOf(const FrameLoad& load, uint64_t seed, int seconds) {
  ReplayLoad replayed(load, seed);
  std::vector<double> ratios;
  for (int i = 0; i < seconds; ++i) ratios.push_back(replayed.RatioAt(i * kSecondNs));
  return ratios;
}

TEST(ReplayLoad, IsThereForItsShareOfTheTimeInStretchesOfTenSeconds) {
  const std::vector<double> ratios = RatiosOf({.ratio = 3, .share = 0.2}, 1, 100'000);
  double busy = 0;
  double begins = 0;
  for (size_t i = 1; i < ratios.size(); ++i) {
    ASSERT_TRUE(ratios[i] == 1 || ratios[i] == 3);
    busy += ratios[i] == 3 ? 1 : 0;
    begins += ratios[i] > ratios[i - 1] ? 1 : 0;
  }
  EXPECT_NEAR(busy / 100'000, 0.2, 0.02);
  EXPECT_NEAR(busy / begins, 10, 1.5);
}

TEST(ReplayLoad, IsTheSameForASeedAndNoneByDefault) {
  const FrameLoad load{.ratio = 3, .share = 0.2};
  EXPECT_EQ(RatiosOf(load, 1, 1000), RatiosOf(load, 1, 1000));
  EXPECT_NE(RatiosOf(load, 1, 1000), RatiosOf(load, 2, 1000));
  EXPECT_EQ(RatiosOf({}, 1, 1000), std::vector<double>(1000, 1));
}

TEST(Replay, ALoadLengthensTheGameAndIsNotCounted) {
  SyntheticTrace trace = TwiceAsSlow();
  trace.detection_ns = [](uint32_t, uint32_t) { return 50'000; };
  const ReplayScene scene = SceneOf(trace);
  ReplaySetup setup;
  setup.options.policy = "paper";
  int decision_count = 0;
  setup.on_decision = [&](const decision::DecisionRecord&) { ++decision_count; };
  Replay(scene, setup);
  const int calm_count = std::exchange(decision_count, 0);
  setup.frame_load = {.ratio = 2, .share = 0.5};
  const ReplayResult loaded = Replay(scene, setup);
  EXPECT_GT(decision_count, calm_count * 5 / 4);
  // Every frame takes 10 ms, except frames that build.
  const double unloaded_ns = scene.frame_count() * 10e6;
  EXPECT_NEAR(static_cast<double>(loaded.total_ns), unloaded_ns, 0.01 * unloaded_ns);
}

}  // namespace
}  // namespace sweepstake::cli
