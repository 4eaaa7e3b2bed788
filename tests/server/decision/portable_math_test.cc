#include "server/decision/portable_math.h"

#include <gtest/gtest.h>

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

TEST(PortableMath, ExpIsWithinTwoUlpOfTheLibraryOverItsWholeRange) {
  uint64_t worst = 0;
  for (double x = -708; x < 709.7; x += 0.00937)
    worst = std::max(worst, UlpsApart(PortableExp(x), std::exp(x)));
  for (double x = -1; x < 1; x += 1.3e-5)
    worst = std::max(worst, UlpsApart(PortableExp(x), std::exp(x)));
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryOverItsWholeRange) {
  uint64_t worst = 0;
  for (double x = 5e-324; x < 1e308; x *= 1.0137) {
    worst = std::max(worst, UlpsApart(PortableLog(x), std::log(x)));
    if (x < 1e-320) x += 5e-324;  // the step would be rounded away
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, LogIsWithinTwoUlpOfTheLibraryAroundOne) {
  uint64_t worst = 0;
  for (double x = 0.5; x < 2; x += 1.7e-5)
    worst = std::max(worst, UlpsApart(PortableLog(x), std::log(x)));
  for (double step = 1e-16; step < 0.5; step *= 1.1) {
    if (1 + step == 1) continue;
    worst = std::max(worst, UlpsApart(PortableLog(1 + step), std::log(1 + step)));
    worst = std::max(worst, UlpsApart(PortableLog(1 - step), std::log(1 - step)));
  }
  EXPECT_LE(worst, 2u);
}

TEST(PortableMath, ExpOfSmallestResultsIsWithinOneStepOfTheLibrary) {
  for (double x = -745.1; x < -708; x += 0.013)
    EXPECT_LE(UlpsApart(PortableExp(x), std::exp(x)), 2u) << x;
}

TEST(PortableMath, SpecialValuesAreThoseOfC) {
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
