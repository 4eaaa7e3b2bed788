#include "engine_client/cli/io/numbers.h"

#include <gtest/gtest.h>

#include <limits>

namespace sweepstake::cli::html {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Significant, RoundsBeforeItCountsTheDigits) {
  EXPECT_EQ(Significant(9.996), "10.0");
  EXPECT_EQ(Significant(9.994), "9.99");
  EXPECT_EQ(Significant(0.0345), "0.0345");
  EXPECT_EQ(Significant(-1234.5, 2), "-1200");
  EXPECT_EQ(Significant(0), "0");
  EXPECT_EQ(Significant(1e-9, 1), "0.000000001");
}

TEST(Significant, AndTheOthersShowADashForNoFiniteNumber) {
  for (const double value : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(Significant(value), "–");
    EXPECT_EQ(Compact(value), "–");
    EXPECT_EQ(Bytes(value), "–");
  }
}

TEST(Grouped, SetsACommaBeforeEveryThirdDigitFromTheRight) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1000), "1,000");
  EXPECT_EQ(Grouped(12'345'678), "12,345,678");
  EXPECT_EQ(GroupedWhole(999.5), "1,000");
}

TEST(Compact, ChangesTheUnitWhereRoundingWouldNeedFourDigits) {
  EXPECT_EQ(Compact(999.4), "999");
  EXPECT_EQ(Compact(999.6), "1k");
  EXPECT_EQ(Compact(2500), "2.5k");
  EXPECT_EQ(Compact(1e6), "1M");
  EXPECT_EQ(Compact(5e12), "5000G");
}

TEST(Bytes, CountsInPowersOfAThousand) {
  EXPECT_EQ(Bytes(0), "0 B");
  EXPECT_EQ(Bytes(512), "512 B");
  EXPECT_EQ(Bytes(11'200), "11.2 kB");
  EXPECT_EQ(Bytes(3.4e6), "3.40 MB");
  EXPECT_EQ(Bytes(2e15), "2000 TB");
}

TEST(LetterCount, CountsCharacters) {
  EXPECT_EQ(LetterCount(""), 0U);
  EXPECT_EQ(LetterCount("a · →"), 5U);
}

}  // namespace
}  // namespace sweepstake::cli::html
