#include "engine_client/adaptive/sequence_slot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

namespace sweepstake {
namespace {

// The value is large, so that a read takes long: without the version checks most reads would be
// torn. lossy_ring_test.cc has the same.
using Block = std::array<uint64_t, 128>;

Block BlockOf(uint64_t value) {
  Block block;
  block.fill(value);
  return block;
}

TEST(SequenceSlot, HasTheLatestValue) {
  SequenceSlot<uint64_t> slot;
  EXPECT_FALSE(slot.Read(0));
  slot.Write(0, 7);
  EXPECT_EQ(slot.Read(0), 7U);
  slot.Write(2, 9);
  EXPECT_FALSE(slot.Read(0));
  EXPECT_EQ(slot.Read(2), 9U);
}

TEST(LatestSlot, IsEmptyBeforeTheFirstValue) {
  LatestSlot<uint64_t> slot;
  EXPECT_FALSE(slot.Get());
  for (uint64_t value = 10; value < 15; ++value) {
    slot.Set(value);
    EXPECT_EQ(slot.Get(), value);
  }
}

TEST(LatestSlot, ConcurrentReadersNeverGetATornOrEarlierValue) {
  constexpr uint64_t kValueCount = 100'000;
  LatestSlot<Block> slot;
  slot.Set(BlockOf(0));
  std::thread writer([&slot] {
    for (uint64_t value = 1; value <= kValueCount; ++value) slot.Set(BlockOf(value));
  });
  uint64_t torn_count = 0;
  uint64_t earlier_count = 0;
  for (uint64_t last = 0; last < kValueCount;) {
    const Block block = *slot.Get();
    if (std::adjacent_find(block.begin(), block.end(), std::not_equal_to<>()) != block.end()) {
      ++torn_count;
    }
    if (block[0] < last) ++earlier_count;
    last = std::max(last, block[0]);
  }
  writer.join();
  EXPECT_EQ(torn_count, 0U);
  EXPECT_EQ(earlier_count, 0U);
}

}  // namespace
}  // namespace sweepstake
