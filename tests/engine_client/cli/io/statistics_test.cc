// Compares the statistics with values from tables and from other programs.
#include "engine_client/cli/io/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::cli {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

TEST(Median, IsTheMiddleValueOrTheMeanOfTheTwoMiddleValues) {
  EXPECT_EQ(Median({1, 2, 9}), 2);
  EXPECT_EQ(Median({1, 2, 4, 9}), 3);
  EXPECT_EQ(Median({5}), 5);
}

TEST(Quantile, UsesTheNearestRank) {
  std::vector<double> values;
  for (int i = 1; i <= 200; ++i) values.push_back(i);
  EXPECT_EQ(Quantile(values, 0.99), 198);
  EXPECT_EQ(Quantile(values, 0), 1);
  EXPECT_EQ(Quantile(values, 1), 200);
  EXPECT_EQ(Quantile({7}, 0.99), 7);
}

TEST(Summarize, AcceptsTimesInAnyOrder) {
  const std::vector<double> times = {4, 1, 9, 2};
  const TimeSummary summary = Summarize(times);
  EXPECT_EQ(summary.ms_median, 3);
  EXPECT_EQ(summary.ms_mean, 4);
  EXPECT_EQ(summary.ms_min, 1);
  EXPECT_EQ(summary.ms_p99, 9);
}

TEST(Statistics, MeanDeviationAndMedianOfASample) {
  const std::vector<double> values{2, 4, 4, 4, 5, 5, 7, 9};
  EXPECT_DOUBLE_EQ(Mean(values), 5);
  EXPECT_NEAR(SampleDeviation(values), 2.1380899352993952, 1e-15);  // √(32/7)
  EXPECT_DOUBLE_EQ(Median(values), 4.5);
  EXPECT_DOUBLE_EQ(Median({3, 1, 2}), 2);
}

TEST(Statistics, NoValuesAndOneValueHaveNoSpread) {
  EXPECT_EQ(Mean({}), 0);
  EXPECT_EQ(Median({}), 0);
  const std::vector<double> one{3};
  EXPECT_EQ(SampleDeviation(one), 0);
  EXPECT_EQ(BootstrapMean(one).low, 3);
  EXPECT_EQ(BootstrapMean(one).high, 3);
}

TEST(BootstrapMean, IsTheSameOnlyForTheSameSeed) {
  const std::vector<double> values{1, 2, 3, 5, 8, 13, 21};
  const Interval first = BootstrapMean(values);
  EXPECT_EQ(first.low, BootstrapMean(values).low);
  EXPECT_EQ(first.high, BootstrapMean(values).high);
  EXPECT_NE(first.low, BootstrapMean(values, {.resample_count = 100, .seed = 2}).low);
}

TEST(BootstrapMean, ReachesAboutTwoStandardErrorsToEachSide) {
  std::vector<double> values;
  for (int i = 0; i < 200; ++i) values.push_back(i % 2 == 0 ? -1 : 1);
  const Interval interval = BootstrapMean(values);
  // The standard error of the mean is 1/√200; the interval reaches 1.96 times that far.
  EXPECT_THAT(interval.high, DoubleNear(0.1386, 0.01));
  EXPECT_THAT(interval.low, DoubleNear(-0.1386, 0.01));
  const Interval half = BootstrapMean(values, {.level = 0.5});
  EXPECT_THAT(half.high, DoubleNear(0.0477, 0.01));
}

TEST(WilcoxonSignedRank, FivePairsOfOneSignGiveOneSixteenth) {
  const std::vector<double> differences{1, 2, 3, 4, 5};
  const WilcoxonResult result = WilcoxonSignedRank(differences);
  EXPECT_EQ(result.pair_count, 5U);
  EXPECT_EQ(result.positive_ranks, 15);
  EXPECT_DOUBLE_EQ(result.probability, 2.0 / 32);
  EXPECT_DOUBLE_EQ(result.smallest_probability, 2.0 / 32);
  EXPECT_DOUBLE_EQ(result.rank_correlation, 1);
}

TEST(WilcoxonSignedRank, AgreesWithTheTextbookExampleOfTenPairs) {
  // Ranks 1, 2 and 5 are negative: W = 8. 25 of 1024 sign patterns have a sum of at most 8.
  const std::vector<double> differences{-1, -2, 3, 4, -5, 6, 7, 8, 9, 10};
  const WilcoxonResult result = WilcoxonSignedRank(differences);
  EXPECT_EQ(result.positive_ranks, 47);
  EXPECT_DOUBLE_EQ(result.probability, 50.0 / 1024);
  EXPECT_DOUBLE_EQ(result.smallest_probability, 2.0 / 1024);
}

TEST(WilcoxonSignedRank, SharesRanksAmongTiesAndOmitsZeros) {
  const std::vector<double> differences{0, 1, 1, -1, 2};
  const WilcoxonResult result = WilcoxonSignedRank(differences);
  EXPECT_EQ(result.pair_count, 4U);
  EXPECT_EQ(result.positive_ranks, 8);  // 2 + 2 + 4
  // Four of the 16 patterns of the ranks 2, 2, 2, 4 have a sum of at most 2: the empty one, and
  // each 2 alone.
  EXPECT_DOUBLE_EQ(result.probability, 8.0 / 16);
}

TEST(WilcoxonSignedRank, HasProbabilityOneWithoutDifferences) {
  const std::vector<double> differences{0, 0};
  EXPECT_EQ(WilcoxonSignedRank(differences).probability, 1);
  EXPECT_EQ(WilcoxonSignedRank(differences).smallest_probability, 1);
  EXPECT_EQ(WilcoxonSignedRank({}).probability, 1);
}

TEST(WilcoxonSignedRank, UsesTheNormalDistributionAboveTheExactSizes) {
  std::vector<double> differences;
  for (int i = 1; i <= 31; ++i) differences.push_back(i % 3 == 0 ? -i : i);
  const WilcoxonResult result = WilcoxonSignedRank(differences);
  EXPECT_EQ(result.positive_ranks, 331);
  // The negative ranks sum to 165. Their expected sum is 248 and its variance 2604, so z = 82.5 /
  // √2604 with a continuity correction of ½.
  EXPECT_NEAR(result.probability, 0.10594, 1e-4);
}

TEST(HolmCorrected, StepsDownAndIsMonotonic) {
  const std::vector<double> probabilities{0.01, 0.04, 0.03, 0.005};
  EXPECT_THAT(HolmCorrected(probabilities),
              ElementsAre(DoubleNear(0.03, 1e-12), DoubleNear(0.06, 1e-12), DoubleNear(0.06, 1e-12),
                          DoubleNear(0.02, 1e-12)));
  const std::vector<double> large{0.9, 0.8};
  EXPECT_THAT(HolmCorrected(large), ElementsAre(1, 1));
}

}  // namespace
}  // namespace sweepstake::cli
