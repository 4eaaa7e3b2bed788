// Tests the parts that only Tracy has: lists in rows of cells, and boxes that enter and leave them.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/tracy/tracy_lists.h"
#include "engine_client/broad_phase/tracy/tracy_rows.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;
using test_support::PairDifference;
using test_support::ScalarPairs;

Aabb CubeAt(float x, float y, float z, float side) {
  return {{x, y, z}, {x + side, y + side, z + side}};
}

// Returns small boxes that are spread out, so that the grid has many cells.
std::vector<Aabb> BrownianBoxes(size_t count = 600) {
  const BoxScene scene("brownian", count, 3);
  return {scene.boxes().begin(), scene.boxes().end()};
}

RowGrids GridsFor(const std::vector<Aabb>& boxes) {
  GridPlan plan;
  plan.Reset();
  plan.MakeGrids(nullptr, boxes);
  return RowGrids(plan);
}

uint32_t RowOf(const Aabb& box, const RowGrids& grids) {
  const std::vector<uint32_t> kept(1 + SoaBoxes::kPadding, 0xFFFFFF00);
  std::vector<uint32_t> moved(1 + SoaBoxes::kPadding);
  std::vector<uint32_t> rows(1 + SoaBoxes::kPadding);
  EXPECT_EQ(FindMovedRows({&box, 1}, grids, kept.data(), moved.data(), rows.data()), 1U);
  return rows[0];
}

TEST(RowGrids, NumberTheRowsOfAllGroupsConsecutively) {
  std::vector<Aabb> boxes = BrownianBoxes();
  for (size_t i = 0; i < 200; ++i) boxes.push_back(CubeAt(boxes[i].min[0], 2, 3, 60));
  const RowGrids grids = GridsFor(boxes);
  ASSERT_EQ(grids.group_count, 3U) << "small boxes, huge ones, and too long ones";
  EXPECT_EQ(grids.row_grids[0].first_cell, 0U);
  EXPECT_EQ(RowOf(boxes[0], grids) < grids.row_grids[1].first_cell,
            RowOf(boxes.back(), grids) >= grids.row_grids[1].first_cell);
}

TEST(RowGrids, SeparateTooLongAndInvalidBoxes) {
  const std::vector<Aabb> boxes = BrownianBoxes();
  const RowGrids grids = GridsFor(boxes);
  EXPECT_LT(RowOf(boxes[1], grids), grids.long_row());
  EXPECT_EQ(RowOf(CubeAt(1, 1, 1, 100), grids), grids.long_row());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(RowOf({{0, nan, 0}, {1, 1, 1}}, grids), kNoRow);
}

TEST(RowGrids, ListOnlyBoxesThatChangedTheirRow) {
  std::vector<Aabb> boxes = BrownianBoxes(100);
  const RowGrids grids = GridsFor(boxes);
  std::vector<uint32_t> kept(100 + SoaBoxes::kPadding, kNoRow);
  std::vector<uint32_t> moved(100 + SoaBoxes::kPadding);
  std::vector<uint32_t> rows(100 + SoaBoxes::kPadding);
  ASSERT_EQ(FindMovedRows(boxes, grids, kept.data(), moved.data(), rows.data()), 100U);
  std::copy_n(rows.begin(), 100, kept.begin());
  EXPECT_EQ(FindMovedRows(boxes, grids, kept.data(), moved.data(), rows.data()), 0U);
  boxes[61] = CubeAt(-40, -40, -40, 200);
  EXPECT_EQ(FindMovedRows(boxes, grids, kept.data(), moved.data(), rows.data()), 1U);
  EXPECT_EQ(moved[0], 61U);
}

class RowLists : public testing::Test {
 protected:
  void Lay() { lists_.Reset(GridsFor(boxes_)); }
  // Returns the first error in the lists, or "" if there is none. "ids": an object is missing or
  // occurs twice. "cells": a cell of the first grid ends before it begins. "order": boxes in such a
  // cell are not sorted by their start along the row. "end": the last cell does not end at the last
  // box.
  std::string Fault() const {
    const GridView view = lists_.View();
    const GroupGrid& grid = view.grids[0];
    const size_t axis = grid.AxisOf(0);
    std::vector<uint32_t> ids(view.lanes.id, view.lanes.id + lists_.size());
    std::sort(ids.begin(), ids.end());
    for (size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] != i) return "ids";
    }
    for (uint32_t cell = grid.first_cell; cell < grid.last_cell(); ++cell) {
      if (view.starts[cell] > view.starts[cell + 1]) return "cells";
      for (size_t k = view.starts[cell] + 1; k < view.starts[cell + 1]; ++k) {
        if (view.lanes.min[axis][k - 1] > view.lanes.min[axis][k]) return "order";
      }
    }
    return view.starts[view.grids.back().last_cell()] == lists_.size() ? "" : "end";
  }

  std::vector<Aabb> boxes_ = BrownianBoxes();
  TracyLists lists_;
};

TEST_F(RowLists, AreSortedAlongTheirRows) {
  Lay();
  lists_.Update(nullptr, {boxes_, boxes_});
  EXPECT_EQ(lists_.size(), boxes_.size());
  EXPECT_EQ(Fault(), "");
}

TEST_F(RowLists, MoveOnlyBoxesThatChangedTheirRow) {
  Lay();
  lists_.Update(nullptr, {boxes_, boxes_});
  EXPECT_EQ(lists_.moved_count(), boxes_.size());
  lists_.Update(nullptr, {boxes_, boxes_});
  EXPECT_EQ(lists_.moved_count(), 0U);
  std::swap(boxes_[3], boxes_[4]);
  lists_.Update(nullptr, {boxes_, boxes_});
  EXPECT_EQ(lists_.moved_count(), 2U);
  EXPECT_EQ(Fault(), "");
}

TEST_F(RowLists, AddNewObjectsAndDropTheLast) {
  Lay();
  for (const size_t count : {100, 600, 599, 17, 0, 300, 600}) {
    const size_t before = lists_.size();
    const auto boxes = std::span<const Aabb>(boxes_).first(count);
    lists_.Update(nullptr, {boxes, boxes});
    EXPECT_EQ(lists_.size(), count);
    EXPECT_EQ(lists_.moved_count(), count > before ? count - before : 0U)
        << "only new boxes may move";
    EXPECT_EQ(Fault(), "");
  }
}

TEST_F(RowLists, AreTheSameOnSeveralThreads) {
  BoxScene scene("brownian", 20'000, 3);
  boxes_.assign(scene.boxes().begin(), scene.boxes().end());
  Lay();
  const auto pool = MakeThreadPool(3);
  TracyLists together;
  together.Reset(GridsFor(boxes_));
  for (int frame = 0; frame < 5; ++frame, scene.Step()) {
    lists_.Update(nullptr, {scene.boxes(), scene.boxes()});
    together.Update(pool.get(), {scene.boxes(), scene.boxes()});
    const uint32_t* const ids = lists_.View().lanes.id;
    ASSERT_TRUE(std::equal(ids, ids + lists_.size(), together.View().lanes.id)) << frame;
  }
  EXPECT_EQ(Fault(), "");
}

TEST(Tracy, FollowsABoxAcrossTheCells) {
  std::vector<Aabb> boxes = BrownianBoxes();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  boxes[17] = CubeAt(-1, 4, 4, 0.9F);
  backend->Build(boxes);
  for (int frame = 0; frame < 60; ++frame) {
    ASSERT_EQ(FindPairsError(*backend, boxes, pairs), "") << "in frame " << frame;
    const float at = static_cast<float>(frame) * 0.2F - 1;
    boxes[17] = CubeAt(at, 4 + at / 3, 4, 0.9F);
    backend->Update(boxes);
  }
}

TEST(Tracy, ReportsAPairWithManySharedCellsOnce) {
  std::vector<Aabb> boxes = BrownianBoxes();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  boxes[1] = CubeAt(0, 0, 0, 5);
  boxes[2] = CubeAt(0.5F, 1, 2, 5);
  boxes[3] = CubeAt(0.5F, 1, 2, 5);
  backend->Build(boxes);
  EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
}

TEST(Tracy, FindsPairsOfABoxThatReturnedBeforeASearch) {
  std::vector<Aabb> boxes = BrownianBoxes();
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
    EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
  }
}

TEST(Tracy, TestsABoxThatOutgrowsItsCellsAgainstAll) {
  std::vector<Aabb> boxes = BrownianBoxes(3000);
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  backend->Build(boxes);
  EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
  const uint64_t before = backend->aabb_check_count();
  boxes[9] = CubeAt(-50, -50, -50, 100);
  backend->Update(boxes);
  EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
  EXPECT_GE(backend->aabb_check_count() + 100, before + 3000);
  EXPECT_LE(backend->aabb_check_count(), before + 4 * 3000);
}

TEST(Tracy, RebuildsTheGridIfTheSceneOutgrowsIt) {
  std::vector<Aabb> boxes = BrownianBoxes();
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  for (Aabb& box : boxes) {  // moves all boxes into one small place, for which Build makes the grid
    for (int axis = 0; axis < 3; ++axis) {
      box.max[axis] = (box.max[axis] - box.min[axis]) * 0.01F + box.min[axis] * 0.001F;
      box.min[axis] *= 0.001F;
    }
  }
  backend->Build(boxes);
  const std::vector<Aabb> spread = BrownianBoxes();
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
