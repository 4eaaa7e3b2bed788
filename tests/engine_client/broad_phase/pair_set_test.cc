#include "engine_client/broad_phase/pair_set.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/box_scenes.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake {
namespace {

TEST(PairSet, HoldsEachPairOnce) {
  PairSet set;
  EXPECT_TRUE(set.Insert({1, 2}));
  EXPECT_FALSE(set.Insert({1, 2}));
  EXPECT_TRUE(set.Insert({1, 3}));
  EXPECT_EQ(set.size(), 2U);
}

TEST(PairSet, ErasesOnlyWhatIsThere) {
  PairSet set;
  EXPECT_FALSE(set.Erase({1, 2}));
  set.Insert({1, 2});
  EXPECT_FALSE(set.Erase({2, 3}));
  EXPECT_TRUE(set.Erase({1, 2}));
  EXPECT_FALSE(set.Erase({1, 2}));
  EXPECT_EQ(set.size(), 0U);
}

TEST(PairSet, IsEmptyAfterClear) {
  PairSet set;
  for (uint32_t i = 0; i < 100; ++i) set.Insert({i, i + 1});
  set.Clear();
  EXPECT_EQ(set.size(), 0U);
  EXPECT_TRUE(set.Insert({5, 6}));
}

// Many pairs in few slots: runs of the probe sequence are long and wrap around.
TEST(PairSet, AgreesWithAnOrderedSetOverManyChanges) {
  test_support::Random random(3);
  PairSet set;
  std::set<OverlapPair> expected;
  for (int step = 0; step < 200000; ++step) {
    const auto a = static_cast<uint32_t>(random.Below(24));
    const OverlapPair pair{a, a + 1 + static_cast<uint32_t>(random.Below(24))};
    if (random.Below(2) == 0) {
      ASSERT_EQ(set.Insert(pair), expected.insert(pair).second);
    } else {
      ASSERT_EQ(set.Erase(pair), expected.erase(pair) == 1);
    }
  }
  const std::vector<OverlapPair> ordered(expected.begin(), expected.end());
  EXPECT_EQ(test_support::Sorted(set.pairs()), ordered);
}

TEST(PairSet, DoesNotAllocateWithinWhatWasReserved) {
  PairSet set;
  set.Reserve(1000);
  const size_t bytes = set.native_bytes();
  for (uint32_t i = 0; i < 1000; ++i) set.Insert({i, i + 1});
  EXPECT_EQ(set.native_bytes(), bytes);
  EXPECT_EQ(set.size(), 1000U);
}

}  // namespace
}  // namespace sweepstake
