#include "engine_client/math/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr int kDraws = 200'000;

struct Moments {
  double mean = 0;
  double variance = 0;
  double third = 0;  // third central moment
};

template <typename Draw>
Moments MomentsOf(Draw draw) {
  std::vector<double> values(kDraws);
  for (double& value : values) value = draw();
  Moments m;
  for (const double value : values) m.mean += value / kDraws;
  for (const double value : values) {
    const double d = value - m.mean;
    m.variance += d * d / kDraws;
    m.third += d * d * d / kDraws;
  }
  return m;
}

TEST(Sampling, NormalHasTheMomentsOfTheStandardNormal) {
  RandomStream stream(11, RandomPurpose::kChoice, 0, 0);
  const Moments m = MomentsOf([&] { return DrawNormal(stream); });
  EXPECT_NEAR(m.mean, 0, 0.01);
  EXPECT_NEAR(m.variance, 1, 0.015);
  EXPECT_NEAR(m.third, 0, 0.03);
}

TEST(Sampling, GammaHasMeanAndVarianceOfItsShape) {
  for (const double shape : {0.3, 1.0, 2.5, 40.0}) {
    RandomStream stream(12, RandomPurpose::kChoice, 0, 0);
    const Moments m = MomentsOf([&] { return math::Exp(DrawLogGamma(shape, stream)); });
    EXPECT_NEAR(m.mean, shape, 5 * std::sqrt(shape / kDraws)) << shape;
    // The variance of the sample variance is (2 + 6/shape) shape² / draws.
    EXPECT_NEAR(m.variance, shape, 5 * shape * std::sqrt((2 + 6 / shape) / kDraws)) << shape;
  }
}

class BetaMoments : public testing::TestWithParam<BetaPosterior> {};

TEST_P(BetaMoments, AgreeWithTheExactOnes) {
  const double a = GetParam().alpha;
  const double b = GetParam().beta;
  RandomStream stream(13, RandomPurpose::kChoice, 0, 0);
  const Moments m = MomentsOf([&] { return DrawBeta(GetParam(), stream); });
  const double variance = a * b / ((a + b) * (a + b) * (a + b + 1));
  const double sigma = std::sqrt(variance);
  const double skewness = 2 * (b - a) * std::sqrt(a + b + 1) / ((a + b + 2) * std::sqrt(a * b));
  EXPECT_NEAR(m.mean, a / (a + b), 5 * sigma / std::sqrt(kDraws));
  EXPECT_NEAR(m.variance / variance, 1, 0.03);
  EXPECT_NEAR(m.third / (sigma * variance), skewness, 0.05 + 0.03 * std::abs(skewness));
}

INSTANTIATE_TEST_SUITE_P(Shapes, BetaMoments,
                         testing::Values(BetaPosterior{1, 1}, BetaPosterior{0.5, 0.5},
                                         BetaPosterior{0.2, 3}, BetaPosterior{2, 5},
                                         BetaPosterior{31.5, 1.8}, BetaPosterior{180, 4},
                                         BetaPosterior{60, 190}, BetaPosterior{1, 11}));

TEST(Sampling, ExtremeParametersGiveANumberInTheUnitInterval) {
  const double smallest = std::numeric_limits<double>::denorm_min();
  for (const double a : {smallest, 1e-300, 1e-6, 1.0, 1e14, 1e300}) {
    for (const double b : {smallest, 1e-300, 1e-6, 1.0, 1e14, 1e300}) {
      for (uint32_t i = 0; i < 50; ++i) {
        RandomStream stream(14, RandomPurpose::kChoice, i, 0);
        const double draw = DrawBeta({a, b}, stream);
        EXPECT_TRUE(draw >= 0 && draw <= 1) << a << " " << b;
      }
    }
  }
}

}  // namespace
}  // namespace sweepstake::decision
