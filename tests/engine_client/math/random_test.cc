#include "engine_client/math/random.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace sweepstake::decision {
namespace {

// Published with the generator (Random123's known-answer vectors for philox4x32, ten rounds).
TEST(Philox, HasThePublishedTestVectors) {
  EXPECT_EQ(Philox4x32({0, 0, 0, 0}, {0, 0}),
            (PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(Philox4x32({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
            (PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(Philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, IsDeterminedByItsAddress) {
  RandomStream a(7, RandomPurpose::kChoice, 3, 1);
  RandomStream b(7, RandomPurpose::kChoice, 3, 1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.NextBits(), b.NextBits());
}

TEST(RandomStream, DiffersWithEveryPartOfItsAddress) {
  std::set<uint64_t> first;
  first.insert(RandomStream(7, RandomPurpose::kChoice, 3, 1).NextBits());
  first.insert(RandomStream(8, RandomPurpose::kChoice, 3, 1).NextBits());
  first.insert(RandomStream(7ull << 32, RandomPurpose::kChoice, 3, 1).NextBits());
  first.insert(RandomStream(7, RandomPurpose::kExplorationOrder, 3, 1).NextBits());
  first.insert(RandomStream(7, RandomPurpose::kChoice, 4, 1).NextBits());
  first.insert(RandomStream(7, RandomPurpose::kChoice, 3ull << 32, 1).NextBits());
  first.insert(RandomStream(7, RandomPurpose::kChoice, 3, 2).NextBits());
  EXPECT_EQ(first.size(), 7u);
}

TEST(RandomStream, UniformsAreInTheOpenUnitIntervalWithTheRightMoments) {
  RandomStream stream(1, RandomPurpose::kChoice, 0, 0);
  double sum = 0;
  double squares = 0;
  constexpr int kDraws = 200'000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = stream.NextUniform();
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    squares += u * u;
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 0.003);  // 4.6 standard errors
  EXPECT_NEAR(squares / kDraws, 1.0 / 3, 0.003);
}

TEST(RandomStream, NumbersBelowABoundAreUniform) {
  RandomStream stream(1, RandomPurpose::kExplorationOrder, 0, 0);
  std::vector<int> counts(7);
  for (int i = 0; i < 70'000; ++i) ++counts.at(stream.NextBelow(7));
  for (const int count : counts) EXPECT_NEAR(count, 10'000, 450);
}

}  // namespace
}  // namespace sweepstake::decision
