#include "engine_client/telemetry/common/lossy_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

namespace sweepstake {
namespace {

// The element is large, so that a read takes long: without the version checks most reads would be
// torn.
using Block = std::array<uint64_t, 128>;

Block BlockOf(uint64_t value) {
  Block block;
  block.fill(value);
  return block;
}

TEST(LossyRing, ReturnsElementsInOrderAndNothingWhenEmpty) {
  LossyRing<uint64_t> ring(4);
  EXPECT_FALSE(ring.Pop().has_value());
  for (uint64_t i = 0; i < 3; ++i) ring.Push(i);
  for (uint64_t i = 0; i < 3; ++i) EXPECT_EQ(ring.Pop(), i);
  EXPECT_FALSE(ring.Pop().has_value());
}

TEST(LossyRing, CountsOverwrittenElementsBeforeAndAfterAPop) {
  LossyRing<uint64_t> ring(4);
  for (uint64_t i = 0; i < 11; ++i) ring.Push(i);
  EXPECT_EQ(ring.lost_count(), 7U);
  EXPECT_EQ(ring.Pop(), 7U);
  EXPECT_EQ(ring.lost_count(), 7U);
  EXPECT_EQ(ring.passed_count(), 8U);
  EXPECT_EQ(ring.pushed_count(), 11U);
}

TEST(LossyRing, NeverReturnsATornElementIfTheWriterOvertakesTheReader) {
  constexpr uint64_t kBlockCount = 200'000;
  LossyRing<Block> ring(2);
  std::thread producer([&ring] {
    for (uint64_t i = 1; i <= kBlockCount; ++i) ring.Push(BlockOf(i));
  });
  uint64_t latest = 0;
  uint64_t read_count = 0;
  uint64_t torn_count = 0;
  while (latest < kBlockCount) {
    const std::optional<Block> block = ring.Pop();
    if (!block) continue;
    ++read_count;
    torn_count += std::count(block->begin(), block->end(), block->front()) != 128 ? 1 : 0;
    EXPECT_GT(block->front(), latest);
    latest = block->front();
  }
  producer.join();
  EXPECT_EQ(torn_count, 0U);
  EXPECT_EQ(read_count + ring.lost_count(), kBlockCount);
}

}  // namespace
}  // namespace sweepstake
