#include "engine_client/decider/pooling/source_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>

namespace sweepstake::decision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Returns how many of the chosen sources each token has.
std::map<int64_t, size_t> CountsOf(const std::vector<int64_t>& tokens, size_t limit) {
  std::map<int64_t, size_t> counts;
  for (const size_t place : ChooseSources(tokens, limit)) ++counts[tokens[place]];
  return counts;
}

TEST(ChooseSources, TakesAllSourcesUpToTheLimit) {
  EXPECT_THAT(ChooseSources({}, 4), IsEmpty());
  EXPECT_THAT(ChooseSources(std::vector<int64_t>{7, 7, 8}, 0), IsEmpty());
  EXPECT_THAT(ChooseSources(std::vector<int64_t>{7, 7, 8}, 4), ElementsAre(0, 1, 2));
}

TEST(ChooseSources, TakesTheLatestSourcesOfTheOnlyToken) {
  EXPECT_THAT(ChooseSources(std::vector<int64_t>(9, 0), 4), ElementsAre(0, 1, 2, 3));
}

TEST(ChooseSources, GivesATokenNoMoreThanItsFairShare) {
  EXPECT_THAT(ChooseSources(std::vector<int64_t>{7, 7, 7, 7, 7, 8, 8, 8}, 4),
              ElementsAre(0, 1, 5, 6));
  EXPECT_THAT(ChooseSources(std::vector<int64_t>{7, 7, 7, 7, 7, 8, 9}, 4), ElementsAre(0, 1, 5, 6));
}

TEST(ChooseSources, GivesAFloodingTokenOnlyOnePlace) {
  std::vector<int64_t> tokens(200, 1);
  for (int64_t token = 2; token < 33; ++token) tokens.push_back(token);
  EXPECT_EQ(CountsOf(tokens, 32).size(), 32u);
}

TEST(ChooseSources, OfMoreTokensThanPlacesPrefersNeitherLateNorLowOnes) {
  std::vector<int64_t> tokens(100);
  std::iota(tokens.begin(), tokens.end(), 1);
  const auto chosen = CountsOf(tokens, 32);
  EXPECT_EQ(chosen.size(), 32u);
  std::reverse(tokens.begin(), tokens.end());
  EXPECT_EQ(CountsOf(tokens, 32), chosen);
  for (int64_t first = 1; first <= 100; first += 25)
    EXPECT_NEAR(std::distance(chosen.lower_bound(first), chosen.lower_bound(first + 25)), 8, 5);
}

TEST(ChooseSources, ConsidersOnlyALimitedNumberOfTheLatestSources) {
  std::vector<int64_t> tokens(kSourcesPerPlace * 4, 1);
  tokens.push_back(2);
  EXPECT_EQ(CountsOf(tokens, 4), (std::map<int64_t, size_t>{{1, 4}}));
}

}  // namespace
}  // namespace sweepstake::decision
