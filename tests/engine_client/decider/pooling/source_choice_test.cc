#include "engine_client/decider/pooling/source_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <string>
#include <vector>

namespace sweepstake::decision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr uint64_t kSeed = 7;

// Chooses among sources of these tokens, whose parties are unknown.
std::vector<size_t> ChooseByTokens(const std::vector<int64_t>& tokens, size_t limit) {
  std::vector<SourceOwner> owners;
  for (const int64_t token : tokens) owners.push_back({token, ""});
  return ChooseSources(owners, limit, kSeed);
}

// Returns how many of the chosen sources each token has.
std::map<int64_t, size_t> CountsOf(const std::vector<int64_t>& tokens, size_t limit) {
  std::map<int64_t, size_t> counts;
  for (const size_t place : ChooseByTokens(tokens, limit)) ++counts[tokens[place]];
  return counts;
}

// Returns how many of the chosen sources of one token each party has.
std::map<std::string, size_t> CountsOfParties(const std::vector<std::string>& parties,
                                              size_t limit) {
  std::vector<SourceOwner> owners;
  for (const std::string& party : parties) owners.push_back({7, party});
  std::map<std::string, size_t> counts;
  for (const size_t place : ChooseSources(owners, limit, kSeed)) ++counts[parties[place]];
  return counts;
}

TEST(ChooseSources, TakesAllSourcesUpToTheLimit) {
  EXPECT_THAT(ChooseByTokens({}, 4), IsEmpty());
  EXPECT_THAT(ChooseByTokens(std::vector<int64_t>{7, 7, 8}, 0), IsEmpty());
  EXPECT_THAT(ChooseByTokens(std::vector<int64_t>{7, 7, 8}, 4), ElementsAre(0, 1, 2));
}

TEST(ChooseSources, TakesTheLatestSourcesOfTheOnlyToken) {
  EXPECT_THAT(ChooseByTokens(std::vector<int64_t>(9, 0), 4), ElementsAre(0, 1, 2, 3));
}

TEST(ChooseSources, GivesATokenNoMoreThanItsFairShare) {
  EXPECT_THAT(ChooseByTokens(std::vector<int64_t>{7, 7, 7, 7, 7, 8, 8, 8}, 4),
              ElementsAre(0, 1, 5, 6));
  EXPECT_THAT(ChooseByTokens(std::vector<int64_t>{7, 7, 7, 7, 7, 8, 9}, 4),
              ElementsAre(0, 1, 5, 6));
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

TEST(ChooseSources, GivesAFloodingPartyOnlyOnePlace) {
  std::vector<std::string> parties(200, "203.0.113.0/24");
  for (int player = 1; player < 32; ++player) parties.push_back("player " + std::to_string(player));
  EXPECT_EQ(CountsOfParties(parties, 32).size(), 32u);
}

// Otherwise one of 16 parties would be a majority of the sources.
TEST(ChooseSources, PlacesThatOthersLeaveFreeDoNotGoToOneParty) {
  std::vector<std::string> parties(20, "203.0.113.0/24");
  for (int player = 0; player < 15; ++player) parties.push_back(std::to_string(player));
  EXPECT_EQ(CountsOfParties(parties, 32).at("203.0.113.0/24"), 1u);
  for (int player = 0; player < 15; ++player) parties.push_back(std::to_string(player));
  EXPECT_EQ(CountsOfParties(parties, 40).at("203.0.113.0/24"), 2u) << "as most of the others";
  EXPECT_EQ(CountsOfParties({"a", "a", "a", "b"}, 32).at("a"), 3u) << "too few to compare";
  EXPECT_EQ(CountsOfParties({"", "", "", "b", "c", "d", "e"}, 32).at(""), 3u) << "unknown parties";
}

TEST(ChooseSources, GivesATenthOfTheNetworksAboutATenthOfThePlaces) {
  std::vector<std::string> parties;
  for (int network = 0; network < 200; ++network)
    parties.push_back("10.0." + std::to_string(network) + ".0/24");
  const auto chosen = CountsOfParties(parties, 32);
  EXPECT_EQ(chosen.size(), 32u);
  const auto among = [&](size_t first) {
    return std::count_if(parties.begin() + static_cast<ptrdiff_t>(first),
                         parties.begin() + static_cast<ptrdiff_t>(first) + 50,
                         [&](const std::string& party) { return chosen.contains(party); });
  };
  for (const size_t first : {0, 50, 100, 150}) EXPECT_NEAR(among(first), 8, 5);
}

TEST(ChooseSources, ATokenWithManyPartiesGetsNoMorePlacesThanOneWithFew) {
  std::vector<SourceOwner> owners(20, {1, "a"});
  const std::vector<std::string> parties = {"b", "c", "d", "e", "f", "g", "h", "i"};
  for (const std::string& party : parties) owners.push_back({2, party});
  const auto chosen = ChooseSources(owners, 8, kSeed);
  EXPECT_EQ(std::count_if(chosen.begin(), chosen.end(),
                          [&](size_t place) { return owners[place].token_id == 1; }),
            4);
}

TEST(ChooseSources, TheSeedDecidesWhoGetsAPlace) {
  std::vector<std::string> parties;
  for (int party = 0; party < 100; ++party) parties.push_back(std::to_string(party));
  std::vector<SourceOwner> owners;
  for (const std::string& party : parties) owners.push_back({7, party});
  const auto chosen = ChooseSources(owners, 32, 1);
  const auto others = ChooseSources(owners, 32, 2);
  std::vector<size_t> both;
  std::set_intersection(chosen.begin(), chosen.end(), others.begin(), others.end(),
                        std::back_inserter(both));
  EXPECT_NEAR(static_cast<double>(both.size()), 10, 8);
}

}  // namespace
}  // namespace sweepstake::decision
