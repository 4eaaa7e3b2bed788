#include "sweepstake/pair_sorter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "engine_client/scene/random.h"
#include "tests/support/allocation_counter.h"

namespace sweepstake {
namespace {

std::vector<OverlapPair> RandomPairs(size_t count, uint32_t ids, uint32_t high_bit, uint64_t seed) {
  SequentialRandom random(seed);
  std::vector<OverlapPair> pairs(count);
  for (OverlapPair& pair : pairs) {
    pair.a = static_cast<uint32_t>(random.Below(ids));
    pair.b = static_cast<uint32_t>(random.Below(ids)) | (random.Below(2) == 0 ? high_bit : 0);
  }
  return pairs;
}

TEST(SortedPairs, AreInAscendingOrderOfAAndThenB) {
  PairSorter sorter;
  for (const size_t count : {0, 1, 2, 127, 128, 129, 5000}) {
    for (const uint32_t ids : {1U, 2U, 100U, 5000U, 1U << 22, 1U << 31}) {
      for (const uint32_t high_bit : {0U, 0x80000000U}) {
        auto pairs = RandomPairs(count, ids, high_bit, count + ids);
        auto expected = pairs;
        std::ranges::sort(expected);
        sorter.Sort(pairs);
        ASSERT_EQ(pairs, expected) << count << " pairs of " << ids << " ids";
      }
    }
  }
}

TEST(SortedPairs, AllocateNothingTheSecondTime) {
  PairSorter sorter;
  auto pairs = RandomPairs(3000, 1000, 0, 1);
  const auto again = pairs;
  sorter.Sort(pairs);
  pairs = again;
  const uint64_t allocations = test_support::ThreadAllocationCount();
  sorter.Sort(pairs);
  EXPECT_EQ(test_support::ThreadAllocationCount(), allocations);
  EXPECT_GE(sorter.native_bytes(), 3000 * sizeof(OverlapPair));
}

}  // namespace
}  // namespace sweepstake
