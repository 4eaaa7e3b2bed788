#include "engine_client/text/counts.h"

#include <gtest/gtest.h>

namespace sweepstake::text {
namespace {

TEST(Grouped, SetsACommaBeforeEveryThirdDigitFromTheRight) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1000), "1,000");
  EXPECT_EQ(Grouped(12'345'678), "12,345,678");
}

TEST(Counted, UsesTheSingularForOneOnly) {
  EXPECT_EQ(Counted(0, "source"), "0 sources");
  EXPECT_EQ(Counted(1, "source"), "1 source");
  EXPECT_EQ(Counted(2, "source"), "2 sources");
  EXPECT_EQ(Counted(1000, "record"), "1,000 records");
}

}  // namespace
}  // namespace sweepstake::text
