#include "engine_client/decider/policy/regime_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sweepstake::decision {
namespace {

constexpr uint32_t kReference = 2;
constexpr uint32_t kInitial = 1;

RegimeBelief BeliefOf(uint32_t place, const std::vector<double>& costs_us) {
  RegimeBelief belief = {.id = {.place = place, .number = place}, .is_present = place == 0};
  for (const double cost_us : costs_us) {
    belief.arms.push_back({.log_cost = {.mean = std::log(cost_us), .variance = 0.01},
                           .difference_variance = 0.001,
                           .is_known = true});
  }
  return belief;
}

// Returns `frame_count` frames, all of which ran an arm of `ran_us`.
RegimeUse UseOf(uint32_t place, uint64_t frame_count, double ran_us,
                const std::vector<double>& costs_us) {
  const auto frames = static_cast<double>(frame_count);
  RegimeUse use = {.id = {.place = place, .number = place},
                   .frame_count = frame_count,
                   .ran_us = frames * ran_us};
  for (const double cost_us : costs_us) use.arm_us.push_back(frames * cost_us);
  use.known_frame_counts.assign(costs_us.size(), frame_count);
  return use;
}

RegimeUse SumOf(const std::vector<RegimeUse>& uses) {
  const size_t arm_count = uses.front().arm_us.size();
  RegimeUse sum = {.arm_us = std::vector<double>(arm_count),
                   .known_frame_counts = std::vector<uint64_t>(arm_count)};
  for (const RegimeUse& use : uses) {
    sum.frame_count += use.frame_count;
    sum.ran_us += use.ran_us;
    for (size_t i = 0; i < arm_count; ++i) {
      sum.arm_us[i] += use.arm_us[i];
      sum.known_frame_counts[i] += use.known_frame_counts[i];
    }
  }
  return sum;
}

// The first arm is the best in the first regime, the second arm in the second one. The session ran
// the best arm in each of them.
class TwoRegimes : public testing::Test {
 protected:
  const std::vector<double> moving_us = {100, 140, 300};
  const std::vector<double> resting_us = {150, 90, 200};
  std::vector<RegimeBelief> beliefs = {BeliefOf(0, moving_us), BeliefOf(1, resting_us)};
  std::vector<RegimeUse> uses = {UseOf(0, 3'000, 100, moving_us), UseOf(1, 1'000, 90, resting_us)};
  RegimeUse total = SumOf(uses);

  void Forget(uint32_t arm) {
    for (RegimeBelief& belief : beliefs) belief.arms[arm].is_known = false;
    for (RegimeUse& use : uses) use.known_frame_counts[arm] = use.frame_count / 2;
    total = SumOf(uses);
  }
  SceneReport Report() const { return ReportOf(beliefs, uses, total, {}, {kReference, kInitial}); }
};

TEST_F(TwoRegimes, HaveABestArmEach) {
  const SceneReport scene = Report();
  ASSERT_EQ(scene.regimes.size(), 2u);
  EXPECT_TRUE(BestArmsDiffer(scene));
  EXPECT_EQ(scene.regimes[0].best_arm, 0u);
  EXPECT_EQ(scene.regimes[1].best_arm, 1u);
  EXPECT_TRUE(scene.regimes[0].is_present);
  EXPECT_FALSE(scene.regimes[1].is_present);
  EXPECT_DOUBLE_EQ(scene.regimes[0].frame_share, 0.75);
  EXPECT_DOUBLE_EQ(scene.regimes[1].frame_share, 0.25);
  EXPECT_GT(scene.regimes[0].arms[0].best_probability, 0.99);
  EXPECT_GT(scene.regimes[1].arms[1].best_probability, 0.99);
}

TEST(BestArms, DifferOnlyBetweenRegimesWithAKnownArm) {
  const auto differ = [](std::vector<std::optional<uint32_t>> best_arms) {
    SceneReport scene;
    for (const std::optional<uint32_t>& arm : best_arms) scene.regimes.push_back({.best_arm = arm});
    return BestArmsDiffer(scene);
  };
  EXPECT_FALSE(differ({}));
  EXPECT_FALSE(differ({std::nullopt, 1}));
  EXPECT_FALSE(differ({1, std::nullopt, 1}));
  EXPECT_TRUE(differ({std::nullopt, 1, 0}));
  EXPECT_TRUE(differ({1, std::nullopt, 0}));
}

TEST_F(TwoRegimes, HaveABestSingleArmByTheMeanCost) {
  const SceneReport scene = Report();
  EXPECT_EQ(scene.total.best_arm, 0u);  // 112.5 µs per frame; the second arm takes 127.5 µs
  EXPECT_NEAR(scene.total.arms[0].cost->us, 112.5, 1e-9);
  EXPECT_NEAR(scene.total.arms[1].cost->us, 127.5, 1e-9);
  EXPECT_GT(scene.total.arms[0].best_probability, 0.95);
  uses = {UseOf(0, 1'000, 100, moving_us), UseOf(1, 1'000, 90, resting_us)};
  total = SumOf(uses);
  EXPECT_EQ(Report().total.best_arm, 1u);  // 115 µs; the first arm takes 125 µs
}

TEST_F(TwoRegimes, SaveTheDifferenceOfWhatRan) {
  const SceneReport scene = Report();
  EXPECT_NEAR(*scene.total.ran_us, 97.5, 1e-9);
  EXPECT_NEAR(*scene.total.saved_against_single_us, 112.5 - 97.5, 1e-9);
  EXPECT_NEAR(*scene.total.saved_against_reference_us, 275 - 97.5, 1e-9);
  EXPECT_NEAR(*scene.regimes[0].saved_against_single_us, 0, 1e-9);
  EXPECT_NEAR(*scene.regimes[1].saved_against_single_us, 60, 1e-9);
  EXPECT_NEAR(*scene.regimes[1].saved_against_reference_us, 110, 1e-9);
}

TEST_F(TwoRegimes, SaveAgainstTheInitialArm) {
  const SceneReport scene = Report();
  EXPECT_NEAR(*scene.total.saved_against_initial_us, 127.5 - 97.5, 1e-9);
  EXPECT_NEAR(*scene.regimes[0].saved_against_initial_us, 40, 1e-9);
  EXPECT_NEAR(*scene.regimes[1].saved_against_initial_us, 0, 1e-9);
  Forget(kInitial);
  EXPECT_FALSE(Report().total.saved_against_initial_us);
  total.known_frame_counts[kInitial] += 1;
  EXPECT_TRUE(Report().total.saved_against_initial_us) << "known in more than half of the frames";
}

TEST_F(TwoRegimes, AreStillInTheTotalWhenForgotten) {
  beliefs.pop_back();
  const SceneReport scene = Report();
  EXPECT_TRUE(scene.regimes.empty());
  EXPECT_NEAR(*scene.total.saved_against_single_us, 15, 1e-9);
}

TEST_F(TwoRegimes, TheReportHasNoFiguresAboutAnArmOfUnknownCost) {
  Forget(0);
  Forget(kReference);
  const SceneReport scene = Report();
  EXPECT_EQ(scene.total.best_arm, 1u);
  EXPECT_EQ(scene.regimes[0].best_arm, 1u);
  EXPECT_FALSE(scene.total.arms[0].cost);
  EXPECT_FALSE(scene.total.saved_against_reference_us);
  EXPECT_FALSE(scene.regimes[1].saved_against_reference_us);
  EXPECT_TRUE(scene.total.saved_against_single_us);
}

TEST_F(TwoRegimes, AnArmOfUnknownCostMayBeTheBestWithAProbability) {
  for (RegimeBelief& belief : beliefs) {
    belief.arms[0].is_known = false;
    belief.arms[0].difference_variance = 0.64;
  }
  const SceneReport scene = Report();
  EXPECT_GT(scene.regimes[1].arms[0].best_probability, 0.1);
  EXPECT_LT(scene.regimes[1].arms[1].best_probability, 0.9);
}

TEST_F(TwoRegimes, AnIntervalHolds95PercentOfTheBelief) {
  const SceneReport scene = Report();
  const ArmReport::Cost cost = *scene.regimes[0].arms[0].cost;
  EXPECT_NEAR(cost.us, 100, 1e-9);
  EXPECT_NEAR(cost.low_us, 100 * std::exp(-0.1 * kDeviations95), 1e-9);
  EXPECT_NEAR(cost.high_us, 100 * std::exp(0.1 * kDeviations95), 1e-9);
  // The two regimes have two thirds and one third of the first arm's time.
  const ArmReport::Cost mean = *scene.total.arms[0].cost;
  EXPECT_NEAR(mean.high_us / mean.us, std::exp(0.1 * kDeviations95 * std::sqrt(5) / 3), 1e-9);
}

TEST_F(TwoRegimes, WithoutAFrameAreDescribedByTheBeliefsAlone) {
  uses.clear();
  total = {.arm_us = {0, 0, 0}, .known_frame_counts = {0, 0, 0}};
  const SceneReport scene = Report();
  EXPECT_EQ(scene.total.best_arm, 0u);
  EXPECT_NEAR(scene.total.arms[0].cost->us, 100, 1e-9);
  EXPECT_FALSE(scene.total.ran_us);
  EXPECT_FALSE(scene.total.saved_against_single_us);
  EXPECT_EQ(scene.regimes[1].best_arm, 1u);
  EXPECT_EQ(scene.regimes[1].frame_share, 0);
}

TEST(ReportOf, UsesTheDiagnosisOfAPolicyThatDoesNotEstimateCosts) {
  const std::vector<RegimeBelief> beliefs = {{.is_present = true}};
  const RegimeUse total = {
      .frame_count = 10, .ran_us = 1'000, .arm_us = {1'000, 1'000}, .known_frame_counts = {0, 0}};
  const SceneReport scene =
      ReportOf(beliefs, {&total, 1}, total, {.best_probability = {0.25, 0.75}, .leader = 1}, {0});
  EXPECT_EQ(scene.total.best_arm, 1u);
  EXPECT_EQ(scene.total.arms[1].best_probability, 0.75);
  EXPECT_FALSE(scene.total.arms[1].cost);
  EXPECT_EQ(*scene.total.ran_us, 100);
  EXPECT_FALSE(scene.total.saved_against_single_us);
  EXPECT_TRUE(scene.regimes.empty());
  EXPECT_TRUE(ReportOf(beliefs, {}, total, {}, {0}).total.arms.empty()) << "nothing is learnt";
}

}  // namespace
}  // namespace sweepstake::decision
