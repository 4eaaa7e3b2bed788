#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "engine_client/cli/game/pair_oracle.h"

namespace sweepstake::cli {
namespace {

const std::vector<OverlapPair> kPairs = {{0, 1}, {2, 7}, {3, 4}, {1, 900}};

TEST(PairFingerprint, IsTheSameInAnyOrder) {
  std::vector<OverlapPair> pairs = kPairs;
  std::sort(pairs.begin(), pairs.end());
  const PairFingerprint right = FingerprintOf(pairs);
  EXPECT_EQ(right.count, 4U);
  do {
    EXPECT_EQ(FingerprintOf(pairs), right);
  } while (std::next_permutation(pairs.begin(), pairs.end()));
}

TEST(PairFingerprint, IsAnotherWhenAPairIsMissingRepeatedSwappedOrReplaced) {
  const PairFingerprint right = FingerprintOf(kPairs);
  std::vector<OverlapPair> pairs = kPairs;
  pairs.pop_back();
  EXPECT_NE(FingerprintOf(pairs), right);
  pairs.push_back(pairs.front());
  EXPECT_NE(FingerprintOf(pairs), right) << "a repeated pair in place of another";
  pairs.back() = {900, 1};
  EXPECT_NE(FingerprintOf(pairs), right) << "a swapped pair";
  pairs.back() = {1, 901};
  EXPECT_NE(FingerprintOf(pairs), right);
  pairs.back() = {1, 900};
  EXPECT_EQ(FingerprintOf(pairs), right);
}

TEST(PairFingerprint, ExchangingIdsBetweenPairsShows) {
  EXPECT_NE(FingerprintOf(std::vector<OverlapPair>{{0, 3}, {1, 2}}),
            FingerprintOf(std::vector<OverlapPair>{{0, 2}, {1, 3}}));
}

TEST(PairFingerprint, OfManySinglePairsHasNoCollision) {
  std::set<std::pair<uint64_t, uint64_t>> seen;
  for (uint32_t a = 0; a < 60; ++a) {
    for (uint32_t b = a + 1; b < 60; ++b) {
      const PairFingerprint print = FingerprintOf(std::vector<OverlapPair>{{a, b}});
      EXPECT_TRUE(seen.insert({print.sums[0], print.sums[1]}).second) << a << ", " << b;
    }
  }
  EXPECT_EQ(FingerprintOf({}), PairFingerprint());
}

}  // namespace
}  // namespace sweepstake::cli
