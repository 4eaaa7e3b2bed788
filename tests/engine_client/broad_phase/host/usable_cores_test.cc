#include "engine_client/broad_phase/host/usable_cores.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

TEST(UsableCores, ThereIsOneAtLeast) { EXPECT_GE(UsableCores(), 1U); }

TEST(IsInRanges, KnowsTheListsOfTheKernel) {
  EXPECT_TRUE(IsInRanges("16-23\n", 16));
  EXPECT_TRUE(IsInRanges("16-23\n", 23));
  EXPECT_FALSE(IsInRanges("16-23\n", 24));
  EXPECT_FALSE(IsInRanges("16-23\n", 15));
  EXPECT_TRUE(IsInRanges("0-3,8,10-11", 8));
  EXPECT_TRUE(IsInRanges("0-3,8,10-11", 10));
  EXPECT_FALSE(IsInRanges("0-3,8,10-11", 9));
}

TEST(IsInRanges, ABrokenListEndsWhereItIsBroken) {
  for (const char* list : {"", "\n", "-", ",", "x", "3-", "3-x", ",5", "3;5"})
    EXPECT_FALSE(IsInRanges(list, 5)) << list;
  EXPECT_TRUE(IsInRanges("5;", 5));
  EXPECT_FALSE(IsInRanges("99999999999999999999", 5));
}

}  // namespace
}  // namespace sweepstake
