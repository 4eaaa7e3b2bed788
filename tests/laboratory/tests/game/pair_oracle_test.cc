#include "tests/laboratory/game/pair_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>
#include <vector>

namespace sweepstake::cli {
namespace {

const std::vector<OverlapPair> kPairs = {{0, 1}, {2, 7}, {3, 4}, {1, 900}};

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<OverlapPair> Found(std::vector<Aabb> boxes) {
  PairOracle oracle;
  const auto pairs = oracle.Find(boxes);
  return {pairs.begin(), pairs.end()};
}

TEST(PairOracle, CountsTouchingBoxesAndBoxesWithoutVolume) {
  EXPECT_EQ(Found({{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}}),
            (std::vector<OverlapPair>{{0, 1}}));
  EXPECT_EQ(Found({{{1, 1, 1}, {1, 1, 1}}, {{1, 1, 1}, {1, 1, 1}}}),
            (std::vector<OverlapPair>{{0, 1}}));
  EXPECT_TRUE(Found({{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 1.5F}, {1, 1, 2}}}).empty());
}

TEST(PairOracle, LeavesOutBoxesThatAreNotValid) {
  EXPECT_TRUE(Found({{{0, 0, 0}, {1, 1, 1}}, {{0, kNan, 0}, {1, 1, 1}}}).empty());
  EXPECT_TRUE(Found({{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {0, 0, 0}}}).empty());
}

TEST(PairOracle, SortsThePairsWhateverTheOrderOfTheBoxes) {
  EXPECT_EQ(Found({{{5, 0, 0}, {9, 1, 1}}, {{0, 0, 0}, {6, 1, 1}}, {{4, 0, 0}, {5, 1, 1}}}),
            (std::vector<OverlapPair>{{0, 1}, {0, 2}, {1, 2}}));
  EXPECT_TRUE(Found({}).empty());
}

TEST(PairOracle, StopsAtItsMaximum) {
  const std::vector<Aabb> boxes(5, Aabb{{0, 0, 0}, {1, 1, 1}});
  PairOracle oracle;
  EXPECT_EQ(oracle.FindUpTo(10, boxes)->size(), 10U);
  const auto refused = oracle.FindUpTo(9, boxes);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(oracle.Find(boxes).size(), 10U) << "a rejected frame leaves no state";
}

TEST(ComparePairs, FindsNoDifferenceInAnyOrder) {
  const std::vector<OverlapPair> right = {{0, 1}, {0, 2}, {3, 4}};
  std::vector<OverlapPair> found = {{3, 4}, {0, 1}, {0, 2}};
  EXPECT_TRUE(ComparePairs(found, right).empty());
}

TEST(ComparePairs, ListsMissingWrongAndRepeatedPairs) {
  const std::vector<OverlapPair> right = {{0, 1}, {0, 2}, {3, 4}};
  std::vector<OverlapPair> found = {{0, 1}, {0, 1}, {4, 3}};
  const PairDifference difference = ComparePairs(found, right);
  EXPECT_EQ(difference.missing, (std::vector<OverlapPair>{{0, 2}, {3, 4}}));
  EXPECT_EQ(difference.extra, (std::vector<OverlapPair>{{0, 1}, {4, 3}}));
}

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
