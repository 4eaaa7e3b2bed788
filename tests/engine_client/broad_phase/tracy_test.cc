// What is Tracy's own: lists that live in cells, and pairs that share several of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/cell_lists.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "engine_client/broad_phase/tracy_ranges.h"
#include "engine_client/broad_phase/tracy_sweep.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/box_scenes.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::MakeOrThrow;
using test_support::PairDifference;
using test_support::Random;
using test_support::ScalarPairs;
using test_support::Verdict;

Aabb CubeAt(float x, float y, float z, float side) {
  return {{x, y, z}, {x + side, y + side, z + side}};
}

TEST(CellLists, KeepTheirIdsWhileTheyGrowAndMove) {
  CellLists lists;
  std::vector<std::vector<uint32_t>> expected(20);
  lists.Reset(std::vector<uint32_t>(20, 1), 20);
  Random random(1);
  for (uint32_t id = 0; id < 5000; ++id) {
    const size_t cell = random.Below(20) * random.Below(20) / 20;
    lists.Append(cell, id);
    expected[cell].push_back(id);
    if (random.Below(40) == 0) {
      expected[cell].resize(expected[cell].size() / 2);
      lists.Truncate(cell, expected[cell].size());
    }
  }
  for (size_t cell = 0; cell < 20; ++cell) {
    EXPECT_TRUE(std::ranges::equal(lists.ids(cell), expected[cell])) << "in cell " << cell;
  }
}

TEST(CellLists, StopGrowingWhenTheirTotalDoes) {
  CellLists lists;
  lists.Reset(std::vector<uint32_t>(50, 10), 50);
  Random random(2);
  size_t bytes = 0;
  for (int round = 0; round < 2000; ++round) {
    const size_t cell = random.Below(50);
    for (uint32_t id = 0; id < 30; ++id) lists.Append(cell, id);
    lists.Truncate(cell, random.Below(20));
    if (round == 1000) bytes = lists.native_bytes();
  }
  EXPECT_EQ(lists.native_bytes(), bytes);
}

// A grid of 4 × 4 × 4 cells of side 1.
GridLayout FourCubed() {
  GridLayout layout;
  for (int axis = 0; axis < 3; ++axis) {
    layout.scale[axis] = 2;
    layout.cells[axis] = 4;
  }
  return layout;
}

CellRange RangeOf(const Aabb& box, const GridLayout& layout) {
  SoaBoxes boxes;
  boxes.Gather({&box, 1});
  std::vector<CellRange> ranges(1 + SoaBoxes::kPadding);
  FindRanges(boxes.Lanes(), layout, ranges.data());
  return ranges[0];
}

TEST(CellRange, SpansTheCellsOfBothCorners) {
  const GridLayout layout = FourCubed();
  const CellRange range = RangeOf({{0.5F, 1.5F, 2.5F}, {1.5F, 1.6F, 3.5F}}, layout);
  EXPECT_EQ(range.first, 0U + 4 * (1 + 4 * 2));
  EXPECT_EQ(range.last, 1U + 4 * (1 + 4 * 3));
  EXPECT_EQ(NumberOf(layout, PositionOf(layout, range.last)), range.last);
}

TEST(CellRange, ClampsWhatLiesOutside) {
  EXPECT_EQ(RangeOf(CubeAt(-1e30F, -5, -5, 1), FourCubed()), (CellRange{0, 0}));
  EXPECT_EQ(RangeOf(CubeAt(1e30F, 1e30F, 3.4e38F, 0), FourCubed()), (CellRange{63, 63}));
}

TEST(CellRange, MarksLargeAndAbsentBoxes) {
  GridLayout layout = FourCubed();
  EXPECT_TRUE(RangeOf(CubeAt(0, 0, 0, 4), layout).IsInCells()) << "64 cells are allowed";
  layout.cells[0] = 5;
  EXPECT_EQ(RangeOf(CubeAt(0, 0, 0, 5), layout).first, CellRange::kLarge);
  layout.cells[0] = layout.cells[1] = layout.cells[2] = 1000;
  EXPECT_EQ(RangeOf(CubeAt(0, 0, 0, 1e30F), layout).first, CellRange::kLarge);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(RangeOf({{0, nan, 0}, {1, 1, 1}}, layout).first, CellRange::kAbsent);
}

// Sweeps one cell of FourCubed that holds all boxes.
class OneCell : public testing::Test {
 protected:
  std::vector<uint32_t> Sweep(const std::vector<Aabb>& boxes, size_t cell) {
    if (lists_.size() == 0) {
      std::vector<uint32_t> sizes(64, 0);
      lists_.Reset(sizes, 64);
      for (uint32_t id = 0; id < boxes.size(); ++id) lists_.Append(cell, id);
    }
    pairs_.Clear();
    SweepCells({boxes, layout_, 0}, lists_, room_, pairs_);
    return {lists_.ids(cell).begin(), lists_.ids(cell).end()};
  }

  GridLayout layout_ = FourCubed();
  CellLists lists_;
  SweepRoom room_;
  PairBuffer pairs_;
};

TEST_F(OneCell, IsSortedAlongTheSweepAxis) {
  const std::vector<Aabb> boxes = {CubeAt(0.5F, 0, 0, 0.1F), CubeAt(0.1F, 0, 0, 0.1F),
                                   CubeAt(0.3F, 0, 0, 0.1F)};
  EXPECT_EQ(Sweep(boxes, 0), (std::vector<uint32_t>{1, 2, 0}));
}

TEST_F(OneCell, DropsABoxThatHasLeft) {
  std::vector<Aabb> boxes = {CubeAt(0.5F, 0, 0, 0.1F), CubeAt(0.1F, 0, 0, 0.1F)};
  EXPECT_EQ(Sweep(boxes, 0).size(), 2U);
  boxes[1] = CubeAt(2, 2, 2, 0.1F);
  EXPECT_EQ(Sweep(boxes, 0), (std::vector<uint32_t>{0}));
}

TEST_F(OneCell, LeavesAPairToTheCellOfTheGreaterMinCorner) {
  // Both reach from cell 0 into cell 1; the second begins in cell 1.
  const std::vector<Aabb> boxes = {CubeAt(0.5F, 0, 0, 0.9F), CubeAt(1.1F, 0, 0, 0.5F)};
  Sweep(boxes, 0);
  EXPECT_TRUE(pairs_.empty());
  lists_ = CellLists();
  Sweep(boxes, 1);
  EXPECT_EQ(pairs_.size(), 1U);
}

// Small boxes all over, so that the grid has many cells.
std::vector<Aabb> Crowd(size_t count = 600) {
  const BoxScene scene("brownian", count, 3);
  return {scene.boxes().begin(), scene.boxes().end()};
}

TEST(Tracy, FollowsABoxAcrossTheCells) {
  std::vector<Aabb> boxes = Crowd();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  boxes[17] = CubeAt(-1, 4, 4, 0.9F);
  backend->Build(boxes);
  for (int frame = 0; frame < 60; ++frame) {
    ASSERT_EQ(Verdict(*backend, boxes, pairs), "") << "in frame " << frame;
    const float at = static_cast<float>(frame) * 0.2F - 1;
    boxes[17] = CubeAt(at, 4 + at / 3, 4, 0.9F);
    backend->Update(boxes);
  }
}

TEST(Tracy, ReportsAPairThatSharesManyCellsOnce) {
  std::vector<Aabb> boxes = Crowd();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  boxes[1] = CubeAt(0, 0, 0, 5);
  boxes[2] = CubeAt(0.5F, 1, 2, 5);
  boxes[3] = CubeAt(0.5F, 1, 2, 5);
  backend->Build(boxes);
  EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
}

TEST(Tracy, TakesABackWhoLeftAndReturnedBeforeItsPairsWereAskedFor) {
  std::vector<Aabb> boxes = Crowd();
  const Aabb home = boxes[5];
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  backend->Build(boxes);
  for (const Aabb& away : {CubeAt(7, 7, 7, 1), CubeAt(-1e30F, 0, 0, 0), Aabb{{1, 1, 1}, {0, 0, 0}},
                           CubeAt(-100, -100, -100, 300)}) {
    boxes[5] = away;
    backend->Update(boxes);
    boxes[5] = home;
    backend->Update(boxes);
    EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
  }
}

TEST(Tracy, TestsABoxOverManyCellsAgainstAll) {
  std::vector<Aabb> boxes = Crowd(3000);
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  backend->Build(boxes);
  EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
  const uint64_t before = backend->aabb_check_count();
  boxes[9] = CubeAt(-50, -50, -50, 100);
  backend->Update(boxes);
  EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
  EXPECT_GE(backend->aabb_check_count() + 100, before + 3000);
  EXPECT_LE(backend->aabb_check_count(), before + 3400);
}

TEST(Tracy, LaysTheGridOutAnewWhenTheSceneOutgrowsIt) {
  std::vector<Aabb> boxes = Crowd();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  for (Aabb& box : boxes) {  // all in one spot, so laid out for that
    for (int axis = 0; axis < 3; ++axis) {
      box.max[axis] = (box.max[axis] - box.min[axis]) * 0.01F + box.min[axis] * 0.001F;
      box.min[axis] *= 0.001F;
    }
  }
  backend->Build(boxes);
  const std::vector<Aabb> spread = Crowd();
  uint64_t checks = 0;
  for (int frame = 0; frame < 40; ++frame) {
    backend->Update(spread);
    pairs.Clear();
    backend->FindPairs(pairs);
    checks = backend->aabb_check_count();
  }
  EXPECT_EQ(PairDifference(pairs.pairs(), ScalarPairs(spread)), "");
  EXPECT_LE(checks, 600U * 100);
}

}  // namespace
}  // namespace sweepstake
