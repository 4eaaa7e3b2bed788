#include "engine_client/math/normal_distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sweepstake::decision {
namespace {

TEST(NormalDistribution, TheCdfAgreesWithErfcOverTheWholeRange) {
  for (double z = -37; z < 9; z += 0.013) {
    const double truth = 0.5 * std::erfc(-z / std::sqrt(2.0));
    ASSERT_NEAR(NormalCdf(z) / truth, 1, 2e-12) << z;
  }
}

TEST(NormalDistribution, TheDensityIsTheSlopeOfTheCdf) {
  for (double z = -6; z < 6; z += 0.1) {
    const double slope = (NormalCdf(z + 1e-4) - NormalCdf(z - 1e-4)) / 2e-4;
    ASSERT_NEAR(NormalDensity(z), slope, 1e-8) << z;
  }
}

TEST(NormalDistribution, ExtremesGiveNeitherOverflowNorNaN) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(NormalCdf(-infinity), 0);
  EXPECT_EQ(NormalCdf(infinity), 1);
  EXPECT_EQ(NormalCdf(-1e300), 0);
  EXPECT_EQ(NormalDensity(1e300), 0);
  EXPECT_TRUE(std::isnan(NormalCdf(std::numeric_limits<double>::quiet_NaN())));
}

TEST(NormalDistribution, TheExpectedGainAgreesWithTheIntegral) {
  for (const double mean : {-3.0, -0.5, 0.0, 0.2, 4.0}) {
    const double deviation = 0.7;
    double integral = 0;
    const double step = 1e-4;
    for (double x = step / 2; x < 12; x += step)
      integral += x * NormalDensity((x - mean) / deviation) / deviation * step;
    EXPECT_NEAR(ExpectedGain(mean, deviation), integral, 1e-7) << mean;
  }
}

TEST(NormalDistribution, TheGainOfACertainDifferenceIsTheDifferenceOrZero) {
  EXPECT_EQ(ExpectedGain(0.25, 0), 0.25);
  EXPECT_EQ(ExpectedGain(-0.25, 0), 0);
  EXPECT_GE(ExpectedGain(-100, 1), 0);
}

}  // namespace
}  // namespace sweepstake::decision
