#include "engine_client/decider/policy/log_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sweepstake::decision {
namespace {

TEST(LogCost, ANanosecondGivesRewardOneAndAStallOfFiveSecondsZero) {
  EXPECT_NEAR(RewardOf(LogCostOf(1e-3)), 1, 1e-12);
  EXPECT_NEAR(RewardOf(LogCostOf(1e-3 * std::sqrt(5e9))), 0.5, 1e-12);
  EXPECT_NEAR(RewardOf(LogCostOf(5e6)), 0, 1e-12);
  EXPECT_EQ(RewardOf(LogCostOf(1e9)), 0);
  EXPECT_EQ(RewardOf(LogCostOf(1e-4)), 1);
}

TEST(LogCost, EqualRatiosOfCostAreEqualDifferencesOfReward) {
  EXPECT_NEAR(RewardOf(LogCostOf(10)) - RewardOf(LogCostOf(11)),
              RewardOf(LogCostOf(10'000)) - RewardOf(LogCostOf(11'000)), 1e-12);
  EXPECT_NEAR(RewardOf(LogCostOf(0.1)) - RewardOf(LogCostOf(0.11)),
              RewardOf(LogCostOf(10)) - RewardOf(LogCostOf(11)), 1e-12);
}

TEST(LogCost, ABeliefSurvivesTheConversionToABetaDistribution) {
  const NormalBelief belief{.mean = 6.2, .variance = 0.0004};
  const NormalBelief back = BeliefOf(BetaOf(belief));
  EXPECT_NEAR(back.mean, belief.mean, 1e-9);
  EXPECT_NEAR(back.variance, belief.variance, 1e-8);
}

TEST(LogCost, AWindowCountsInverselyToItsNoiseVariance) {
  const double reward = 0.6;
  const Increment sharp = LogCostIncrement(2, reward, 0.01 * 0.01);
  const Increment blurred = LogCostIncrement(2, reward, 0.1 * 0.1);
  EXPECT_NEAR(sharp.alpha / blurred.alpha, 100, 1e-9);
  EXPECT_NEAR(sharp.alpha / (sharp.alpha + sharp.beta), reward, 1e-12);
  EXPECT_EQ(sharp.arm, 2u);
  EXPECT_EQ(sharp.window_count, 1u);
}

TEST(LogCost, TheRatioOfTwoCostsHasTheUncertaintyOfBoth) {
  const BetaPosterior slow = BetaOf({std::log(300), 0.03 * 0.03});
  const BetaPosterior fast = BetaOf({std::log(200), 0.04 * 0.04});
  const CostRatio ratio = CostRatioOf(slow, fast);
  EXPECT_NEAR(ratio.median, 1.5, 1e-6);
  EXPECT_NEAR(ratio.low, 1.5 * std::exp(-1.96 * 0.05), 1e-4);
  EXPECT_NEAR(ratio.high, 1.5 * std::exp(1.96 * 0.05), 1e-4);
}

TEST(LogCost, NothingIsInfiniteOrNaN) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double cost_us : {0.0, -1.0, 5e-324, 1e300, infinity, std::nan("")}) {
    EXPECT_GE(LogCostOf(cost_us), kMinLogCost);
    EXPECT_LE(LogCostOf(cost_us), kMaxLogCost);
  }
  for (const double mean : {-100.0, 0.0, 100.0}) {
    for (const double variance : {0.0, 1e-300, 1e9}) {
      const BetaPosterior shown = BetaOf({mean, variance});
      EXPECT_TRUE(std::isfinite(shown.alpha) && shown.alpha > 0) << mean << ' ' << variance;
      EXPECT_TRUE(std::isfinite(shown.beta) && shown.beta > 0) << mean << ' ' << variance;
      const CostRatio ratio = CostRatioOf(shown, BetaOf({0, 1e9}));
      EXPECT_TRUE(std::isfinite(ratio.high) && ratio.low >= 0) << mean << ' ' << variance;
    }
  }
  EXPECT_EQ(EvidenceOf(0, 0.01), 1);
  EXPECT_EQ(EvidenceOf(1, 0), 1e12);
}

}  // namespace
}  // namespace sweepstake::decision
