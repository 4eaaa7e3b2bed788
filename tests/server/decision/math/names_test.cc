#include "server/decision/math/names.h"

#include <gtest/gtest.h>

#include <array>

#include "server/decision/math/hash.h"

namespace sweepstake::math {
namespace {

constexpr std::array<std::string_view, 4> kFruits = {"apple", "banana", "pear", "peach"};

TEST(Names, TheNearestNameNeedsTheFewestEdits) {
  EXPECT_EQ(NearestName("peer", kFruits), "pear");
  EXPECT_EQ(NearestName("bananas", kFruits), "banana");
  EXPECT_EQ(NearestName("pple", kFruits), "apple");
  EXPECT_EQ(NearestName("anything", {}), "");
}

TEST(Names, TheFirstOfEquallyNearNamesIsTaken) {
  constexpr std::array<std::string_view, 2> names = {"ab", "ac"};
  EXPECT_EQ(NearestName("ad", names), "ab");
}

TEST(Names, AnUnknownNameListsTheNearestFirstAndEveryOtherOnce) {
  EXPECT_EQ(UnknownName("fruit", "peach\n", kFruits),
            "unknown fruit 'peach?', must be one of peach, apple, banana, pear");
}

TEST(Names, AMessageOfOneLineHoldsNoControlCharacterAndAtMost200Bytes) {
  EXPECT_EQ(PrintableLine("a\tb\x7f\xc3"), "a?b??");
  EXPECT_EQ(PrintableLine(std::string(1000, 'x')), std::string(200, 'x'));
}

TEST(Hash, GivesThePublishedValues) {
  EXPECT_EQ(Fnv1a(kFnv1aStart, ""), 0xCBF29CE484222325U);
  EXPECT_EQ(Fnv1a(kFnv1aStart, "foobar"), 0x85944171F73967E8U);
  EXPECT_EQ(Fnv1aOfWord(kFnv1aStart, 0x6F6F66U), Fnv1a(kFnv1aStart, std::string_view("foo\0", 4)));
  // The first outputs of splitmix64 from state 1234567.
  uint64_t state = 1234567;
  EXPECT_EQ(Mix64(state += kGoldenGamma), 6457827717110365317U);
  EXPECT_EQ(Mix64(state += kGoldenGamma), 3203168211198807973U);
}

}  // namespace
}  // namespace sweepstake::math
