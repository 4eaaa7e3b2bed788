#include "engine_client/broad_phase/common/rebuild_debt.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

TEST(RebuildDebt, IsTheExcessOfSearchesOverTheCheapest) {
  RebuildDebt debt;
  debt.AddSearch(100);
  EXPECT_FALSE(debt.Exceeds(0));
  debt.AddSearch(130);
  debt.AddSearch(120);
  EXPECT_TRUE(debt.Exceeds(49));
  EXPECT_FALSE(debt.Exceeds(50));
}

TEST(RebuildDebt, ComparesLaterSearchesWithACheaperOne) {
  RebuildDebt debt;
  debt.AddSearch(100);
  debt.AddSearch(60);
  debt.AddSearch(100);
  EXPECT_TRUE(debt.Exceeds(39));
  EXPECT_FALSE(debt.Exceeds(40));
}

TEST(RebuildDebt, IsZeroAfterARebuild) {
  RebuildDebt debt;
  debt.AddSearch(100);
  debt.AddSearch(500);
  debt.Clear();
  debt.AddSearch(500);
  EXPECT_FALSE(debt.Exceeds(0));
}

TEST(RebuildFrames, AreOneToSixByTheExcessCost) {
  EXPECT_EQ(RebuildFrames(100, 0), 6U);
  EXPECT_EQ(RebuildFrames(100, 99), 3U);
  EXPECT_EQ(RebuildFrames(100, 10'000), 1U);
  EXPECT_EQ(SearchCost(100, 5), 140U);
}

}  // namespace
}  // namespace sweepstake
