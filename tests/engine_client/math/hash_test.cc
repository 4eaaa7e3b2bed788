#include "engine_client/math/hash.h"

#include <gtest/gtest.h>

#include <string_view>

namespace sweepstake::math {
namespace {

TEST(Hash, HasThePublishedValues) {
  EXPECT_EQ(Fnv1a(kFnv1aStart, ""), 0xCBF29CE484222325U);
  EXPECT_EQ(Fnv1a(kFnv1aStart, "foobar"), 0x85944171F73967E8U);
  EXPECT_EQ(Fnv1aOfWord(kFnv1aStart, 0x6F6F66U), Fnv1a(kFnv1aStart, std::string_view("foo\0", 4)));
  // The first outputs of splitmix64 from state 1234567.
  SplitMix64 random{1234567};
  EXPECT_EQ(random.Next(), 6457827717110365317U);
  EXPECT_EQ(random.Next(), 3203168211198807973U);
}

}  // namespace
}  // namespace sweepstake::math
