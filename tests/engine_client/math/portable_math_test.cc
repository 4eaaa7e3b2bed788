#include "engine_client/math/portable_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sweepstake::math {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTwoUlp = 2 * std::numeric_limits<double>::epsilon();

// Returns the distance in units in the last place. REQUIRES: both finite and of the same sign.
uint64_t UlpsApart(double a, double b) {
  const auto x = std::bit_cast<int64_t>(a);
  const auto y = std::bit_cast<int64_t>(b);
  return static_cast<uint64_t>(x > y ? x - y : y - x);
}

// Returns the largest distance of `ours` from `theirs` at `count` evenly spaced points from `low`
// on.
template <typename Ours, typename Theirs>
uint64_t WorstOverGrid(double low, double step, int count, Ours ours, Theirs theirs) {
  uint64_t worst = 0;
  for (int i = 0; i < count; ++i) {
    const double x = low + i * step;
    worst = std::max(worst, UlpsApart(ours(x), theirs(x)));
  }
  return worst;
}

double LibraryExp(double x) { return std::exp(x); }
double LibraryLog(double x) { return std::log(x); }
double LibraryExpm1(double x) { return std::expm1(x); }
double LibraryLog1p(double x) { return std::log1p(x); }

TEST(PortableMath, ExpIsWithinTwoUlpOfTheLibraryOverItsWholeRange) {
  EXPECT_LE(WorstOverGrid(-708, 0.00937, 151'000, Exp, LibraryExp), 2u);
  EXPECT_LE(WorstOverGrid(-1, 1.3e-5, 150'000, Exp, LibraryExp), 2u);
}

TEST(PortableMath, ExpOfSmallestResultsIsWithinTwoStepsOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-745.1, 0.013, 2'800, Exp, LibraryExp), 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryOverItsWholeRange) {
  uint64_t worst = 0;
  // Steps through exponents and mantissas together, subnormal numbers included.
  for (uint64_t bits = 1; bits < 0x7ff0'0000'0000'0000; bits += 0x000f'3a91'27c4'5b1d / 64) {
    const double x = std::bit_cast<double>(bits);
    worst = std::max(worst, UlpsApart(Log(x), std::log(x)));
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryAroundOne) {
  EXPECT_LE(WorstOverGrid(0.5, 1.7e-5, 90'000, Log, LibraryLog), 2u);
  uint64_t worst = 0;
  for (int exponent = 1; exponent <= 52; ++exponent) {
    const double step = std::bit_cast<double>(static_cast<uint64_t>(1023 - exponent) << 52);
    worst = std::max(worst, UlpsApart(Log(1 + step), std::log(1 + step)));
    worst = std::max(worst, UlpsApart(Log(1 - step), std::log(1 - step)));
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, ExpMinusOneIsWithinSixUlpOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-40, 0.00137, 500'000, Expm1, LibraryExpm1), 6u);
  EXPECT_LE(WorstOverGrid(-1e-3, 1.3e-8, 150'000, Expm1, LibraryExpm1), 6u);
}

TEST(PortableMath, LogOfOnePlusIsWithinSixUlpOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-0.9999, 1.7e-5, 900'000, Log1p, LibraryLog1p), 6u);
  EXPECT_LE(WorstOverGrid(-1e-3, 1.3e-8, 150'000, Log1p, LibraryLog1p), 6u);
}

TEST(PortableMath, SinAndCosFollowTheLibraryOverManyTurns) {
  for (int i = 0; i < 20'000; ++i) {
    const double x = -1000 + 0.1000037 * i;
    EXPECT_NEAR(Sin(x), std::sin(x), kTwoUlp) << "at " << x;
    EXPECT_NEAR(Cos(x), std::cos(x), kTwoUlp) << "at " << x;
  }
}

TEST(PortableMath, PowAndCubeRootFollowTheLibrary) {
  for (int i = 1; i < 20'000; ++i) {
    const double x = i / 20'000.0;
    EXPECT_NEAR(Pow(x, 0.75), std::pow(x, 0.75), 8 * kTwoUlp) << "at " << x;
    const double volume = 497.3 * i;
    // Use long double, because some libraries' cbrt for double has a larger error than ours.
    const auto reference = static_cast<double>(std::cbrt(static_cast<long double>(volume)));
    EXPECT_NEAR(CubeRoot(volume), reference, kTwoUlp * reference) << "at " << volume;
  }
}

TEST(PortableMath, AnglesThatAreTooLargeOrNotFiniteGiveNaN) {
  for (const double x : {kInfinity, -kInfinity, std::nan(""), 1e16}) {
    EXPECT_TRUE(std::isnan(Sin(x))) << x;
    EXPECT_TRUE(std::isnan(Cos(x))) << x;
  }
}

TEST(PortableMath, SpecialValuesAgreeWithTheCStandard) {
  EXPECT_EQ(Pow(0, 0.75), 0);
  EXPECT_EQ(Pow(0, 0), 1);
  EXPECT_EQ(CubeRoot(0), 0);
  EXPECT_EQ(Sin(0), 0);
  EXPECT_EQ(Cos(0), 1);
  EXPECT_EQ(Expm1(1e-300), 1e-300);
  EXPECT_EQ(Expm1(-kInfinity), -1);
  EXPECT_EQ(Log1p(-1), -kInfinity);
  EXPECT_EQ(Log1p(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(Log1p(-2)));
  EXPECT_EQ(Exp(0), 1);
  EXPECT_EQ(Exp(-kInfinity), 0);
  EXPECT_EQ(Exp(kInfinity), kInfinity);
  EXPECT_EQ(Exp(710), kInfinity);
  EXPECT_EQ(Exp(-1e300), 0);
  EXPECT_TRUE(std::isnan(Exp(std::nan(""))));
  EXPECT_EQ(Log(1), 0);
  EXPECT_EQ(Log(0), -kInfinity);
  EXPECT_EQ(Log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(Log(-1)));
  EXPECT_TRUE(std::isnan(Log(std::nan(""))));
}

// Compares the bits, which must be the same on every platform and with every library.
TEST(PortableMath, BitsEqualTheRecordedOnes) {
  EXPECT_EQ(std::bit_cast<uint64_t>(Exp(1)), 0x4005bf0a8b14576au);
  EXPECT_EQ(std::bit_cast<uint64_t>(Log(10)), 0x40026bb1bbb55516u);
}

}  // namespace
}  // namespace sweepstake::math
