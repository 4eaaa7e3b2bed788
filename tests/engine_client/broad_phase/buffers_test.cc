#include <gtest/gtest.h>

#include <cstdint>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/pair_cursor.h"

namespace sweepstake {
namespace {

TEST(AlignedBuffer, IsAlignedAndCountsItsCapacity) {
  AlignedBuffer<float> buffer;
  EXPECT_EQ(buffer.capacity_bytes(), 0U);
  buffer.EnsureDiscarding(10);
  EXPECT_EQ(buffer.capacity_bytes(), 40U);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(buffer.data()) % 64, 0U);
}

TEST(AlignedBuffer, DoesNotMoveWhileThereIsRoom) {
  AlignedBuffer<uint32_t> buffer;
  buffer.EnsureDiscarding(100);
  const uint32_t* const before = buffer.data();
  buffer.EnsureDiscarding(1);
  buffer.EnsureKeeping(100, 100);
  EXPECT_EQ(buffer.data(), before);
}

TEST(AlignedBuffer, KeepsTheRequestedElementsWhenItGrows) {
  AlignedBuffer<uint32_t> buffer;
  buffer.EnsureKeeping(3, 0);
  for (uint32_t i = 0; i < 3; ++i) buffer[i] = i;
  buffer.EnsureKeeping(1000, 3);
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(buffer[i], i);
}

TEST(AlignedBuffer, GrowsRarelyIfTheCountRisesOneByOne) {
  AlignedBuffer<uint32_t> buffer;
  int growths = 0;
  for (size_t count = 1; count <= 10000; ++count) {
    const size_t before = buffer.capacity();
    buffer.EnsureDiscarding(count);
    growths += buffer.capacity() != before ? 1 : 0;
  }
  EXPECT_LT(growths, 30);
}

TEST(PairBuffer, IsUsableAfterAMove) {
  PairBuffer from;
  from.Append({1, 2});
  const PairBuffer to = std::move(from);
  EXPECT_EQ(to.size(), 1U);
  EXPECT_TRUE(from.empty());  // NOLINT(bugprone-use-after-move): that is what is tested
  EXPECT_EQ(from.capacity_bytes(), 0U);
  from.Append({3, 4});
  EXPECT_EQ(from.pairs()[0], (OverlapPair{3, 4}));
}

TEST(AlignedBuffer, IsUsableAfterAMove) {
  AlignedBuffer<uint32_t> from;
  from.EnsureDiscarding(8);
  const AlignedBuffer<uint32_t> to = std::move(from);
  EXPECT_EQ(to.capacity(), 8U);
  EXPECT_EQ(from.capacity(), 0U);  // NOLINT(bugprone-use-after-move): that is what is tested
  from.EnsureDiscarding(4);
  EXPECT_NE(from.data(), nullptr);
}

TEST(PairCursor, WritesAllPairsWhileTheBufferGrows) {
  PairBuffer buffer;
  buffer.Append({1, 2});
  PairCursor cursor(buffer);
  for (uint32_t i = 0; i < 5000; ++i) cursor.Append(i + 1, i);
  cursor.Flush();
  ASSERT_EQ(buffer.size(), 5001U);
  EXPECT_EQ(buffer.pairs()[0], (OverlapPair{1, 2}));
  for (uint32_t i = 0; i < 5000; ++i) ASSERT_EQ(buffer.pairs()[i + 1], (OverlapPair{i, i + 1}));
}

TEST(PairCursor, LeavesRoomForARegisterPastTheEnd) {
  PairBuffer buffer;
  PairCursor cursor(buffer);
  for (int round = 0; round < 3000; ++round) {
    OverlapPair* const end = cursor.Room(1);
    for (size_t lane = 0; lane < PairBuffer::kSlack; ++lane) end[lane] = {0, 1};
    cursor.Advance(1);
  }
  cursor.Flush();
  EXPECT_EQ(buffer.size(), 3000U);
}

}  // namespace
}  // namespace sweepstake
