#include "engine_client/cli/io/numbers.h"

#include <gtest/gtest.h>

namespace sweepstake::cli {
namespace {

TEST(Grouped, SetsACommaBeforeEveryThirdDigitFromTheRight) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1000), "1,000");
  EXPECT_EQ(Grouped(12'345'678), "12,345,678");
}

TEST(GroupedWhole, RoundsToTheNearestWholeNumber) {
  EXPECT_EQ(GroupedWhole(999.4), "999");
  EXPECT_EQ(GroupedWhole(999.5), "1,000");
}

TEST(LetterCount, CountsCharacters) {
  EXPECT_EQ(LetterCount(""), 0U);
  EXPECT_EQ(LetterCount("a · →"), 5U);
}

}  // namespace
}  // namespace sweepstake::cli
