#include "engine_client/decider/policy/relative_cost_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/math/normal_distribution.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {
namespace {

// Arms of known log-costs. The lane measures each arm with its own bias. The load of the scene
// changes the costs of all arms.
class FilterTest : public testing::Test {
 protected:
  static constexpr uint32_t kArms = 4;

  double Noise(double deviation) { return deviation * DrawNormal(random_); }

  // Simulates one decision interval: the load moves, the lane sweeps, and the active arm has a live
  // window.
  void RunInterval(RelativeCostFilter& filter, uint32_t active) {
    load_ += Noise(load_step_);
    filter.Advance(1);
    if (with_lane_) Sweep(filter, active);
    filter.ObserveLive(active, cost_[active] + load_ + core_load_ + Noise(0.01));
  }

  void Sweep(RelativeCostFilter& filter, uint32_t active) {
    ++sweep_;
    const double offset = 0.2 + Noise(0.03);
    Visit(filter, active, offset);
    for (uint32_t arm = 0; arm < kArms; ++arm) {
      if (arm != active) Visit(filter, arm, offset);
    }
  }

  void Visit(RelativeCostFilter& filter, uint32_t arm, double offset) {
    filter.ObserveShadow(arm, sweep_, cost_[arm] + bias_[arm] + load_ + offset + Noise(0.03));
  }

  static double Deviation(const NormalBelief& belief) { return std::sqrt(belief.variance); }

  RandomStream random_{7, RandomPurpose::kChoice, 0, 0};
  std::vector<double> cost_ = {5, 5.1, 5.4, 8.5};
  std::vector<double> bias_ = std::vector<double>(kArms, 0.0);
  double load_ = 0;
  double core_load_ = 0;  // log of the slowdown by other work on the frame thread's core
  double load_step_ = 0.05;
  bool with_lane_ = true;
  uint64_t sweep_ = 0;
};

TEST_F(FilterTest, HasNoBeliefsAtFirst) {
  const RelativeCostFilter filter(kArms);
  EXPECT_EQ(filter.Difference(0, 3).mean, 0);
  EXPECT_GT(Deviation(filter.Difference(0, 3)), 1);
}

TEST_F(FilterTest, SweepsGiveTheDifferencesWithinTheirDeviation) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  for (uint32_t arm = 1; arm < kArms; ++arm) {
    const NormalBelief difference = filter.Difference(arm, 0);
    EXPECT_LT(Deviation(difference), 0.32) << arm;
    EXPECT_NEAR(difference.mean, cost_[arm] - cost_[0], 3 * Deviation(difference)) << arm;
  }
}

TEST_F(FilterTest, AChangingLoadDoesNotChangeTheDifferences) {
  RelativeCostFilter filter(kArms);
  load_step_ = 0.3;
  for (int i = 0; i < 30; ++i) RunInterval(filter, 0);
  EXPECT_GT(std::abs(load_), 0.3);
  EXPECT_NEAR(filter.Difference(1, 0).mean, 0.1, 0.1);
  EXPECT_NEAR(filter.LogCost(0).mean, cost_[0] + load_, 0.4);
}

TEST_F(FilterTest, RunningAnArmLiveRevealsTheBiasOfTheLane) {
  RelativeCostFilter filter(kArms);
  bias_[1] = -0.2;  // the lane wrongly finds arm 1 cheaper than arm 0
  for (int i = 0; i < 10; ++i) RunInterval(filter, 0);
  EXPECT_LT(filter.Difference(1, 0).mean, 0);
  EXPECT_GT(Deviation(filter.Difference(1, 0)), 0.05);
  for (int i = 0; i < 5; ++i) RunInterval(filter, 1);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  EXPECT_NEAR(filter.Difference(1, 0).mean, 0.1, 0.1);
  EXPECT_LT(Deviation(filter.Difference(1, 0)), 0.1);
}

TEST_F(FilterTest, OneOutlierMovesLittleAndASecondOneIsFollowed) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  const double before = filter.Difference(1, 0).mean;
  cost_[1] += 1;
  RunInterval(filter, 0);
  EXPECT_NEAR(filter.Difference(1, 0).mean, before, 0.3);
  RunInterval(filter, 0);
  EXPECT_NEAR(filter.Difference(1, 0).mean, before + 1, 0.2);
}

TEST_F(FilterTest, AnOutlyingSweepDoesNotChangeTheLevel) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  const double before = filter.LogCost(0).mean;
  load_ += 1;
  Sweep(filter, 0);
  load_ -= 1;
  filter.ObserveLive(0, cost_[0] + load_);
  EXPECT_NEAR(filter.LogCost(0).mean, before, 0.1);
  EXPECT_NEAR(filter.Difference(1, 0).mean, cost_[1] - cost_[0], 0.1);
}

// The load falls during the switch from arm 0 to arm 1.
TEST_F(FilterTest, AChangeOfLoadAtASwitchDoesNotChangeTheDifferences) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 60; ++i) RunInterval(filter, 0);
  load_ -= 0.5;
  for (int i = 0; i < 10; ++i) RunInterval(filter, 1);
  EXPECT_NEAR(filter.Difference(1, 0).mean, cost_[1] - cost_[0], 0.2);
}

// Other work uses the core of the frame thread twice. It ends the second time during the switch
// from arm 0 to arm 1.
TEST_F(FilterTest, OtherWorkOnTheFrameThreadsCoreIsNotBlamedOnAnArm) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  for (const uint32_t next : {0U, 1U}) {
    core_load_ = std::log(4);
    for (int i = 0; i < 6; ++i) RunInterval(filter, 0);
    EXPECT_NEAR(filter.Difference(1, 0).mean, cost_[1] - cost_[0], 0.15);
    EXPECT_NEAR(filter.LogCost(0).mean, cost_[0] + load_, 0.4);
    core_load_ = 0;
    for (int i = 0; i < 3; ++i) RunInterval(filter, next);
    EXPECT_NEAR(filter.Difference(1, 0).mean, cost_[1] - cost_[0], 0.15);
    EXPECT_NEAR(filter.LogCost(next).mean, cost_[next] + load_, 0.1);
  }
}

TEST_F(FilterTest, AChangeThatTheLaneDoesNotShowIsNotBlamedOnTheArm) {
  for (const bool lane_would_show : {false, true}) {
    RelativeCostFilter filter(kArms);
    for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
    const double before = filter.Difference(1, 0).mean;
    for (int i = 0; i < 3; ++i) {
      filter.Advance(1);
      filter.ObserveLive(0, cost_[0] + load_ + std::log(4), lane_would_show);
    }
    const double shift = std::abs(filter.Difference(1, 0).mean - before);
    EXPECT_EQ(shift < 0.02, lane_would_show) << shift;
  }
}

TEST_F(FilterTest, AStallOfAFewWindowsIsForgottenAfterNewVisits) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  for (int i = 0; i < 3; ++i) {
    filter.Advance(1);
    filter.ObserveLive(0, cost_[0] + load_ + 2.5);
  }
  for (int i = 0; i < 20; ++i) RunInterval(filter, 1);
  EXPECT_NEAR(filter.Difference(1, 0).mean, 0.1, 0.3);
}

TEST_F(FilterTest, WithoutALaneLiveWindowsGiveTheDifference) {
  RelativeCostFilter filter(kArms);
  with_lane_ = false;
  load_step_ = 0;
  for (const uint32_t active : {0, 3, 1, 0}) {
    for (int i = 0; i < 3; ++i) RunInterval(filter, active);
  }
  EXPECT_NEAR(filter.Difference(3, 0).mean, 3.5, 0.3);
  EXPECT_NEAR(filter.Difference(1, 0).mean, 0.1, 0.1);
  EXPECT_GT(Deviation(filter.Difference(2, 0)), 0.5);  // never measured
}

TEST_F(FilterTest, ALateLaneHasTheSameDriftAsAnEarlyOne) {
  RelativeCostFilter early(kArms), late(kArms);
  late.Advance(400);
  for (RelativeCostFilter* filter : {&early, &late}) {
    const double expected = filter->LogCost(0).mean;
    filter->ObserveShadow(0, 1, expected);
    filter->ObserveShadow(1, 1, expected);
  }
  // The visits' deviation combines the biases of both arms and the noise of both visits, which
  // weigh 7/6 because their innovations are 0. Drifts widen the late lane's biases and the prior.
  const auto combined = [](double prior, double visits) {
    return prior * visits / std::hypot(prior, visits);
  };
  const double visits = std::hypot(0.2, 0.2, std::sqrt(6.0 / 7) * std::hypot(0.2, 0.2));
  const double prior = std::hypot(0.8, 0.8);
  EXPECT_NEAR(Deviation(early.Difference(0, 1)), combined(prior, visits), 1e-6);
  const double drift = std::sqrt(2 * 400) * 0.005, bias_drift = std::sqrt(2 * 400) * 0.001;
  EXPECT_NEAR(Deviation(late.Difference(0, 1)),
              combined(std::hypot(prior, drift), std::hypot(visits, bias_drift)), 1e-6);
}

TEST_F(FilterTest, ThePriorSetsTheDifferencesButNotTheLevel) {
  RelativeCostFilter filter(kArms);
  filter.SetPrior(0, {.mean = 2, .variance = 0.02});
  filter.SetPrior(1, {.mean = 3, .variance = 0.02});
  EXPECT_NEAR(Deviation(filter.Difference(1, 0)), 0.2, 1e-9);
  filter.ObserveLive(0, 5);
  EXPECT_NEAR(filter.LogCost(1).mean, 6, 0.1);
}

TEST_F(FilterTest, AnAssumedCostReplacesTheBeliefAboutOneArm) {
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 20; ++i) RunInterval(filter, 0);
  filter.Assume(0, 15);
  EXPECT_EQ(filter.LogCost(0).mean, 15);
  EXPECT_NEAR(filter.LogCost(1).mean, cost_[1] + load_, 0.2);
}

// A trial may coincide with other work, so one bound is not followed entirely.
TEST_F(FilterTest, BoundsAdjustTheBiasOfTheLaneSoThatVisitsKeepThem) {
  bias_[1] = -1;  // the lane finds the second arm the cheapest
  RelativeCostFilter filter(kArms);
  for (int i = 0; i < 30; ++i) RunInterval(filter, 0);
  EXPECT_LT(filter.Difference(1, 0).mean, -0.5);
  const double level = filter.LogCost(0).mean;
  filter.ObserveBound(1, cost_[1] + load_);
  EXPECT_LT(filter.LogCost(1).mean, cost_[1] + load_ - 0.2);
  for (int i = 0; i < 2; ++i) filter.ObserveBound(1, cost_[1] + load_);
  EXPECT_NEAR(filter.LogCost(1).mean, cost_[1] + load_, 0.15);
  EXPECT_NEAR(filter.LogCost(0).mean, level, 0.1);
  for (int i = 0; i < 30; ++i) RunInterval(filter, 0);
  const double kept = filter.Difference(1, 0).mean;
  EXPECT_NEAR(kept, cost_[1] - cost_[0], 0.2);
  filter.ObserveBound(1, cost_[1] + load_ - 2);
  EXPECT_NEAR(filter.Difference(1, 0).mean, kept, 0.01) << "the bound is below the known cost";
}

TEST_F(FilterTest, WithoutALaneABoundHoldsToo) {
  RelativeCostFilter filter(kArms);
  with_lane_ = false;
  for (int i = 0; i < 10; ++i) RunInterval(filter, 0);
  filter.ObserveBound(1, 8 + load_);
  EXPECT_NEAR(filter.Difference(1, 0).mean, 8 - cost_[0], 0.2);
}

// The costs of two arms say little about a third one, which may cost less than both.
TEST_F(FilterTest, ABoundTruncatesAVagueBelief) {
  RelativeCostFilter filter(3);
  for (int i = 0; i < 3; ++i) filter.ObserveLive(0, 5);
  for (int i = 0; i < 3; ++i) filter.ObserveLive(2, 7);
  const NormalBelief before = filter.Difference(0, 1);
  ASSERT_GT(ExpectedGain(before.mean, std::sqrt(before.variance)), 0.05);
  filter.ObserveBound(1, 5.7);
  const NormalBelief after = filter.Difference(0, 1);
  EXPECT_LT(after.mean, before.mean);
  EXPECT_LT(ExpectedGain(after.mean, std::sqrt(after.variance)), 0.005);
  EXPECT_NEAR(filter.LogCost(0).mean, 5, 0.1);
}

// A sweep measures only eight frames, while frame times in this scene differ tenfold. It has no
// result for two of the arms.
TEST_F(FilterTest, TheFirstLiveWindowSetsTheLevelOfAllArms) {
  RelativeCostFilter filter(kArms);
  filter.ObserveShadow(0, 1, cost_[0] - 2.3);
  filter.ObserveShadow(1, 1, cost_[1] - 2.3);
  filter.ObserveLive(0, cost_[0]);
  EXPECT_NEAR(filter.LogCost(0).mean, cost_[0], 0.15);
  EXPECT_NEAR(filter.Difference(1, 0).mean, cost_[1] - cost_[0], 0.3);
  EXPECT_NEAR(filter.Difference(2, 0).mean, 0, 0.5);
}

TEST_F(FilterTest, ABoundOfTheLaneOnlyTruncatesTheBelief) {
  RelativeCostFilter filter(kArms);
  for (uint64_t sweep = 1; sweep <= 5; ++sweep) {
    filter.ObserveShadow(0, sweep, 5);
    filter.ObserveShadowBound(1, sweep, 5.5);
    filter.ObserveLive(0, 5);
  }
  const NormalBelief difference = filter.Difference(1, 0);
  EXPECT_GT(difference.mean, 0.7);
  EXPECT_GT(Deviation(difference), 0.3) << "it may cost many times as much";
  filter.ObserveShadow(0, 6, 5);
  filter.ObserveShadowBound(1, 6, 1);
  EXPECT_NEAR(filter.Difference(1, 0).mean, difference.mean, 0.01)
      << "the belief has no mass below that bound";
  filter.ObserveShadow(0, 7, 5);
  filter.ObserveShadowBound(1, 7, 15);
  EXPECT_GT(filter.Difference(1, 0).mean, 5) << "a bound above the belief counts like a cost";
}

// If the first visit of a sweep gives only a bound, the noise is still estimated from the
// differences of the other arms.
TEST_F(FilterTest, ABoundCanBeTheFirstVisitOfASweep) {
  RelativeCostFilter filter(kArms);
  filter.ObserveLive(0, 5);
  const double before = filter.shadow_noise();
  for (uint64_t sweep = 1; sweep <= 20; ++sweep) {
    filter.ObserveShadowBound(0, sweep, 1);
    filter.ObserveShadow(1, sweep, sweep % 2 == 0 ? 5.0 : 5.001);
  }
  EXPECT_NE(filter.shadow_noise(), before);
}

TEST_F(FilterTest, AbsurdCostsAreClampedAndVariancesStayFinite) {
  RelativeCostFilter filter(kArms);
  const double infinity = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 2'000; ++i) {
    filter.Advance(i % 100 == 0 ? 1e6 : 1);
    const double cost = i % 3 == 0 ? infinity : i % 3 == 1 ? -infinity : std::nan("");
    filter.ObserveShadow(static_cast<uint32_t>(i) % kArms, static_cast<uint64_t>(i / 7), cost);
    filter.ObserveLive(static_cast<uint32_t>(i / 5) % kArms, cost);
    filter.ObserveBound(static_cast<uint32_t>(i / 3) % kArms, cost);
    filter.ObserveShadowBound(static_cast<uint32_t>(i / 2) % kArms, static_cast<uint64_t>(i / 7),
                              cost);
    for (uint32_t arm = 0; arm < kArms; ++arm) {
      ASSERT_GE(filter.LogCost(arm).mean, kMinLogCost);
      ASSERT_LE(filter.LogCost(arm).mean, kMaxLogCost);
      ASSERT_TRUE(filter.Difference(arm, 0).variance < 1e9);
    }
  }
}

}  // namespace
}  // namespace sweepstake::decision
