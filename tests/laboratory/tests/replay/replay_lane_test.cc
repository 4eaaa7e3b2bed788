// Tests the shadow lane of a replayed game, on a trace in which all numbers are known.
#include "tests/laboratory/replay/replay_lane.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "tests/laboratory/tests/replay/replay_fixtures.h"

namespace sweepstake::cli {
namespace {

using testing::DoubleNear;
using testing::Each;
using testing::ElementsAre;

constexpr int64_t kMsNs = 1'000'000;

// AxisSweep's frames take 10 ms, KDTree's 20 ms.
class ReplayLaneTest : public testing::Test {
 protected:
  // Returns the visits that end in the next `count` events, each at its due time.
  std::vector<ShadowSample> Visits(int count, uint32_t active_arm = 0) {
    std::vector<ShadowSample> visits;
    for (int i = 0; i < count; ++i) {
      const int64_t now_ns = lane_.next_event_ns();
      if (const auto sample = lane_.Advance({now_ns, 0, 7, 0, active_arm}))
        visits.push_back(*sample);
    }
    return visits;
  }

  const ReplayScene scene_ = SceneOf(TwiceAsSlow());
  const ShadowScheduleOptions options_{.duty_ratio = 0.5};
  ReplayLane lane_{scene_, options_};
};

TEST_F(ReplayLaneTest, SweepsAllArmsFromTheStartTheActiveOneFirst) {
  EXPECT_EQ(lane_.next_event_ns(), 0);
  const auto visits = Visits(3, 1);
  ASSERT_EQ(visits.size(), 2U) << "the first event begins the sweep";
  EXPECT_EQ(visits[0].arm, 1U);
  EXPECT_EQ(visits[1].arm, 0U);
  EXPECT_EQ(visits[0].flags, kShadowActive);
  EXPECT_EQ(visits[1].flags, 0U);
  EXPECT_EQ(visits[0].first_frame_index, 7U);
  EXPECT_EQ(visits[0].object_count, 1000U);
  EXPECT_EQ(lane_.visit_count(), 2U);
}

TEST_F(ReplayLaneTest, MeasuresTheFramesAfterTheWarmUpAndTheBuildApart) {
  const auto visits = Visits(2);
  ASSERT_EQ(visits.size(), 1U);
  EXPECT_EQ(visits[0].frame_count, kShadowBurstFrames - 1 - kShadowWarmUpFrames);
  EXPECT_NEAR(static_cast<double>(visits[0].detection_time_ns), 11e6, 1);
  EXPECT_NEAR(static_cast<double>(visits[0].build_time_ns), 40e6, 1);
}

TEST_F(ReplayLaneTest, AVisitLastsAsLongAsItsFramesTake) {
  Visits(1);
  // A visit takes 115 ms: 40 ms to build, two frames of 10 ms and five of 11 ms. The first visit of
  // a sweep is made twice.
  EXPECT_NEAR(static_cast<double>(lane_.next_event_ns()), 2 * 115e6, 10);
  Visits(1);
  EXPECT_NEAR(static_cast<double>(lane_.busy_ns()), 2 * 115e6, 10);
  EXPECT_NEAR(static_cast<double>(lane_.next_event_ns()), 460e6, 10);
}

TEST_F(ReplayLaneTest, SpacesItsSweepsByTheBudget) {
  Visits(3);
  EXPECT_NEAR(static_cast<double>(lane_.next_event_ns()), 2 * 460e6, 20)
      << "the lane works for half of the time";
}

TEST_F(ReplayLaneTest, ASweepWaitsUntilTheSearchesAllowForIt) {
  Visits(3);
  const int64_t due_ns = lane_.next_event_ns();
  lane_.Advance({due_ns, /*search_ns=*/500 * kMsNs, 7, 0, 0});
  const int64_t asks_again_ns = lane_.next_event_ns();
  EXPECT_EQ(asks_again_ns, due_ns + 10 * kMsNs) << "a frame later";
  // The next sweep begins when the frame thread has searched for 750 ms. This is twice the 460 ms
  // of the first sweep, minus the time that the lane may work in advance.
  lane_.Advance({asks_again_ns, /*search_ns=*/750 * kMsNs, 8, 0, 0});
  EXPECT_NEAR(static_cast<double>(lane_.next_event_ns() - asks_again_ns), 2 * 115e6, 20);
}

TEST_F(ReplayLaneTest, AVisitEndsAtItsTimeCap) {
  // Frames that take 10 ms in the game took 50 µs in the trace.
  ReplayLane capped(scene_, {.duty_ratio = 0.5, .visit_cap_ns = 45 * kMsNs / 200});
  capped.Advance({});
  const auto sample = capped.Advance({capped.next_event_ns(), 0, 0, 0});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->flags, kShadowActive | kShadowCapped);
  EXPECT_NEAR(static_cast<double>(capped.busy_ns()), 2 * 50e6, 10)
      << "the frame that reaches the cap ends the visit";
}

TEST_F(ReplayLaneTest, RepeatsNoMoreOfAVisitThanTheRealLane) {
  Visits(1, /*active_arm=*/1);
  // KDTree's visit takes 230 ms of the game. A frame that takes 20 ms in the game took 100 µs in
  // the trace, a factor of 200.
  const double repeated_ns = 200.0 * kShadowWarmUpNs;
  EXPECT_NEAR(static_cast<double>(lane_.next_event_ns()), 230e6 + repeated_ns, 20);
}

TEST_F(ReplayLaneTest, WarmingAnArmUpDelaysTheVisitUnderWay) {
  Visits(1);
  const int64_t visit_end_ns = lane_.next_event_ns();
  // The preparation takes 40 ms to build, then three frames. Each takes 10 ms of the game, or the
  // arm's own time if that is longer.
  const int64_t ready_ns = lane_.WarmUp(0, {5 * kMsNs, 0, 1, 1, 1});
  EXPECT_NEAR(static_cast<double>(ready_ns), (5 + 40 + 10 + 10 + 11) * 1e6, 10);
  EXPECT_EQ(lane_.next_event_ns(), visit_end_ns + ready_ns - 5 * kMsNs);
}

// Returns the times of AxisSweep in the lane's first sweeps ÷ the times of a lane without errors.
std::vector<double> RatiosWith(const LaneErrors& errors, uint64_t seed = 1) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplayLane lane(scene, {.duty_ratio = 1}, errors, seed);
  std::vector<double> ratios;
  while (ratios.size() < 200) {
    const auto sample = lane.Advance({lane.next_event_ns(), 0, 0, 0});
    if (sample && sample->arm == 0) {
      ratios.push_back(static_cast<double>(sample->detection_time_ns) / 11e6);
    }
  }
  return ratios;
}

double SpreadOf(const std::vector<double>& ratios) {
  double squares = 0;
  for (const double ratio : ratios) squares += std::log(ratio) * std::log(ratio);
  return std::sqrt(squares / static_cast<double>(ratios.size()));
}

TEST(ReplayLane, MeasuresAnArmWithItsRatio) {
  EXPECT_THAT(RatiosWith({.arm_ratios = {0.8, 1.2}}), Each(DoubleNear(0.8, 1e-6)));
}

TEST(ReplayLane, HasOneBiasForAnArmInAGame) {
  std::vector<double> biases;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const auto ratios = RatiosWith({.bias_deviation = 0.3}, seed);
    EXPECT_THAT(ratios, Each(DoubleNear(ratios[0], 1e-6)));
    biases.push_back(ratios[0]);
  }
  EXPECT_NEAR(SpreadOf(biases), 0.3, 0.07);
}

TEST(ReplayLane, HasNoiseInEachVisitOfItsOwn) {
  const auto ratios = RatiosWith({.noise_deviation = 0.3});
  EXPECT_NEAR(SpreadOf(ratios), 0.3, 0.05);
  EXPECT_EQ(std::set(ratios.begin(), ratios.end()).size(), ratios.size());
  EXPECT_EQ(RatiosWith({.noise_deviation = 0.3}), ratios) << "of one seed";
}

TEST(ReplayLane, IsInterruptedInAShareOfItsVisits) {
  const auto ratios = RatiosWith({.spike_ratio = 0.1});
  const auto spikes =
      std::count_if(ratios.begin(), ratios.end(), [](double each) { return each > 1.001; });
  EXPECT_NEAR(static_cast<double>(spikes), 20, 10);
  EXPECT_GT(*std::max_element(ratios.begin(), ratios.end()), 2);
  EXPECT_GE(*std::min_element(ratios.begin(), ratios.end()), 0.999);
}

TEST(ReplayLane, TakesFromFramesDuringAVisit) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplayLane lane(scene, {.duty_ratio = 0.5}, {.contention_ratio = 1.25});
  EXPECT_EQ(lane.frame_ratio(), 1);
  lane.Advance({});
  EXPECT_EQ(lane.frame_ratio(), 1.25);
  for (int visit = 0; visit < 2; ++visit) lane.Advance({lane.next_event_ns(), 0, 0, 0});
  EXPECT_EQ(lane.frame_ratio(), 1) << "between two sweeps";
}

TEST(ReplayLane, WarmUpsGoOverTheEndOfTheTraceToItsBeginning) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplayLane lane(scene, {});
  const uint32_t last = scene.trace_frame_count() - 1;
  EXPECT_EQ(lane.WarmUp(1, {0, 0, last, 0}), lane.WarmUp(1, {0, 0, 0, 0}));
}

}  // namespace
}  // namespace sweepstake::cli
