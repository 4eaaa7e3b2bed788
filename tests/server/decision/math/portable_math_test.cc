#include "server/decision/math/portable_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sweepstake::decision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Distance in units in the last place; both finite and of the same sign.
uint64_t UlpsApart(double a, double b) {
  const auto x = std::bit_cast<int64_t>(a);
  const auto y = std::bit_cast<int64_t>(b);
  return static_cast<uint64_t>(x > y ? x - y : y - x);
}

// The worst distance of `ours` from `theirs` at `count` evenly spaced points from `low` on.
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
  EXPECT_LE(WorstOverGrid(-708, 0.00937, 151'000, PortableExp, LibraryExp), 2u);
  EXPECT_LE(WorstOverGrid(-1, 1.3e-5, 150'000, PortableExp, LibraryExp), 2u);
}

TEST(PortableMath, ExpOfSmallestResultsIsWithinTwoStepsOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-745.1, 0.013, 2'800, PortableExp, LibraryExp), 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryOverItsWholeRange) {
  uint64_t worst = 0;
  // Steps through exponents and mantissas together, subnormal numbers included.
  for (uint64_t bits = 1; bits < 0x7ff0'0000'0000'0000; bits += 0x000f'3a91'27c4'5b1d / 64) {
    const double x = std::bit_cast<double>(bits);
    worst = std::max(worst, UlpsApart(PortableLog(x), std::log(x)));
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryAroundOne) {
  EXPECT_LE(WorstOverGrid(0.5, 1.7e-5, 90'000, PortableLog, LibraryLog), 2u);
  uint64_t worst = 0;
  for (int exponent = 1; exponent <= 52; ++exponent) {
    const double step = std::bit_cast<double>(static_cast<uint64_t>(1023 - exponent) << 52);
    worst = std::max(worst, UlpsApart(PortableLog(1 + step), std::log(1 + step)));
    worst = std::max(worst, UlpsApart(PortableLog(1 - step), std::log(1 - step)));
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, ExpMinusOneIsWithinSixUlpOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-40, 0.00137, 500'000, PortableExpm1, LibraryExpm1), 6u);
  EXPECT_LE(WorstOverGrid(-1e-3, 1.3e-8, 150'000, PortableExpm1, LibraryExpm1), 6u);
}

TEST(PortableMath, LogOfOnePlusIsWithinSixUlpOfTheLibrary) {
  EXPECT_LE(WorstOverGrid(-0.9999, 1.7e-5, 900'000, PortableLog1p, LibraryLog1p), 6u);
  EXPECT_LE(WorstOverGrid(-1e-3, 1.3e-8, 150'000, PortableLog1p, LibraryLog1p), 6u);
}

TEST(PortableMath, SpecialValuesAreThoseOfC) {
  EXPECT_EQ(PortableExpm1(1e-300), 1e-300);
  EXPECT_EQ(PortableExpm1(-kInfinity), -1);
  EXPECT_EQ(PortableLog1p(-1), -kInfinity);
  EXPECT_EQ(PortableLog1p(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(PortableLog1p(-2)));
  EXPECT_EQ(PortableExp(0), 1);
  EXPECT_EQ(PortableExp(-kInfinity), 0);
  EXPECT_EQ(PortableExp(kInfinity), kInfinity);
  EXPECT_EQ(PortableExp(710), kInfinity);
  EXPECT_EQ(PortableExp(-1e300), 0);
  EXPECT_TRUE(std::isnan(PortableExp(std::nan(""))));
  EXPECT_EQ(PortableLog(1), 0);
  EXPECT_EQ(PortableLog(0), -kInfinity);
  EXPECT_EQ(PortableLog(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(PortableLog(-1)));
  EXPECT_TRUE(std::isnan(PortableLog(std::nan(""))));
}

// The bits themselves: the same on every platform, whatever its library.
TEST(PortableMath, BitsAreTheOnesRecorded) {
  EXPECT_EQ(std::bit_cast<uint64_t>(PortableExp(1)), 0x4005bf0a8b14576au);
  EXPECT_EQ(std::bit_cast<uint64_t>(PortableLog(10)), 0x40026bb1bbb55516u);
}

}  // namespace
}  // namespace sweepstake::decision
