// Tests that quantized boxes overlap wherever the original boxes do, for any coordinate range.
#include "engine_client/broad_phase/common/byte_boxes.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "engine_client/scene/box_scenes.h"

namespace sweepstake {
namespace {

bool BytesOverlap(const ByteLanes& lanes, size_t a, size_t b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap = overlap && lanes.low[axis][a] <= lanes.high[axis][b] &&
              lanes.low[axis][b] <= lanes.high[axis][a];
  }
  return overlap;
}

CoordinateRange RangeOf(float low, float high) {
  CoordinateRange range;
  for (int axis = 0; axis < 3; ++axis) {
    range.low[axis] = low;
    range.high[axis] = high;
  }
  return range;
}

TEST(ByteBoxes, OverlapWhereverTheBoxesOverlap) {
  ByteBoxes bytes;
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = MakeDegenerateScene(name, 150, 3);
    const auto boxes = scene->aabbs();
    for (const CoordinateRange& range :
         {CoordinateRange::Sample(boxes), RangeOf(2, 3), RangeOf(0, 0), RangeOf(-1e38F, 1e38F)}) {
      bytes.Resize(boxes.size(), false);
      std::iota(bytes.ids(), bytes.ids() + boxes.size(), 0U);
      bytes.Fill(boxes, range, {}, 0, boxes.size());
      for (size_t a = 0; a < boxes.size(); ++a) {
        EXPECT_EQ(bytes.Lanes().record[a], RecordOf(boxes[a]));
        for (size_t b = 0; b < a; ++b) {
          EXPECT_GE(BytesOverlap(bytes.Lanes(), a, b), Overlap(boxes[a], boxes[b])) << name;
        }
      }
    }
  }
}

TEST(ByteBoxes, SeparateBoxesThatAreATenthOfTheRangeApart) {
  const Aabb boxes[] = {{{0, 0, 0}, {1, 1, 1}}, {{1.2F, 0, 0}, {2, 1, 1}}, {{9, 9, 9}, {9, 9, 9}}};
  ByteBoxes bytes;
  bytes.Resize(3, false);
  std::iota(bytes.ids(), bytes.ids() + 3, 0U);
  bytes.Fill(boxes, RangeOf(0, 10), {}, 0, 3);
  EXPECT_FALSE(BytesOverlap(bytes.Lanes(), 0, 1));
  EXPECT_FALSE(BytesOverlap(bytes.Lanes(), 1, 2));
}

size_t BytePairs(std::span<const Aabb> boxes) {
  ByteBoxes bytes;
  bytes.Resize(boxes.size(), false);
  std::iota(bytes.ids(), bytes.ids() + boxes.size(), 0U);
  bytes.Fill(boxes, CoordinateRange::Sample(boxes), {}, 0, boxes.size());
  size_t pairs = 0;
  for (size_t a = 0; a < boxes.size(); ++a) {
    for (size_t b = 0; b < a; ++b) pairs += BytesOverlap(bytes.Lanes(), a, b) ? 1 : 0;
  }
  return pairs;
}

// With a straight line from coordinates to bytes, all boxes of a crowd overlap in bytes.
TEST(ByteBoxes, SeparateBoxesOfCrowdsThatAreFarApart) {
  const BoxScene near("brownian", 1000, 3);
  const BoxScene far("far-crowds", 1000, 3);
  EXPECT_LE(BytePairs(far.boxes()), 2 * BytePairs(near.boxes()));
  const BoxScene exponential("exponential-spacing", 1000, 3);
  EXPECT_LE(BytePairs(exponential.boxes()), 1000U * 20);
}

TEST(ByteBoxes, ArePaddedWithInvalidBoxes) {
  ByteBoxes bytes;
  for (const size_t count : {0, 1, 63, 64, 65}) {
    const BoxScene scene("brownian", count, 8);
    bytes.Resize(count, true);
    std::iota(bytes.ids(), bytes.ids() + count, 0U);
    bytes.Fill(scene.boxes(), CoordinateRange::Sample(scene.boxes()), {}, 0, count);
    for (size_t slot = count; slot < (count / 64 + 1) * 64; ++slot)
      EXPECT_EQ(bytes.Lanes().record[slot], kInvalidRecord);
  }
}

TEST(ByteBoxes, AreTheSameWithSharedRecords) {
  const BoxScene scene("broken-boxes", 100, 8);
  const auto boxes = scene.boxes();
  const CoordinateRange range = CoordinateRange::Sample(boxes);
  std::vector<BoxRecord> records(101, kInvalidRecord);
  StoreRecords(boxes, records.data());
  ByteBoxes own;
  ByteBoxes borrowing;
  own.Resize(100, true);
  borrowing.ResizeFor(records.data(), 100);
  for (ByteBoxes* each : {&own, &borrowing})
    for (uint32_t slot = 0; slot < 100; ++slot) each->ids()[slot] = 99 - slot;
  own.Fill(boxes, range, {}, 0, 100);
  borrowing.Fill(range, {}, 0, 100);
  const ByteLanes a = own.Lanes();
  const ByteLanes b = borrowing.Lanes();
  for (size_t slot = 0; slot < 100; ++slot) {
    EXPECT_EQ(a.record[slot], b.record[b.id[slot]]);
    EXPECT_EQ(a.begin[slot], b.begin[slot]);
    EXPECT_EQ(a.end[slot], b.end[slot]);
    for (size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(a.low[axis][slot], b.low[axis][slot]);
      EXPECT_EQ(a.high[axis][slot], b.high[axis][slot]);
    }
  }
}

TEST(SweepAxis, StepsIncreaseWithThePosition) {
  const SweepAxis axis{false, -5, 10, 99};
  uint32_t before = 0;
  for (float x = -20; x < 20; x += 0.01F) {
    EXPECT_GE(axis.Step(x), before);
    before = axis.Step(x);
  }
  EXPECT_EQ(axis.Step(-kInfinity), 0U);
  EXPECT_EQ(axis.Step(kInfinity), 99U);
}

}  // namespace
}  // namespace sweepstake
