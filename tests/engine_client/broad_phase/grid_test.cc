// Tests the parts that only Grid has: groups of similar shapes, and cells that depend neither on a
// huge box nor on an outlier.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <vector>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<Aabb> OrdinaryBoxes(size_t count) {
  const BoxScene scene("brownian", count, 7);
  return {scene.boxes().begin(), scene.boxes().end()};
}

// Returns boxes of 0.1 × 0.1 × 10 with the long side along any axis.
std::vector<Aabb> Needles(size_t count) {
  std::vector<Aabb> boxes = OrdinaryBoxes(count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      boxes[i].max[axis] = boxes[i].min[axis] + (axis == i % 3 ? 10.0F : 0.1F);
    }
  }
  return boxes;
}

uint64_t ChecksFor(const std::vector<Aabb>& boxes) {
  const auto grid = MakeOrThrow("Grid");
  PairBuffer pairs;
  grid->Build(boxes);
  EXPECT_EQ(FindPairsError(*grid, boxes, pairs), "");
  return grid->aabb_check_count();
}

GridPlan PlanFor(const std::vector<Aabb>& boxes) {
  GridPlan plan;
  plan.Reset();
  plan.MakeGrids(nullptr, boxes);
  return plan;
}

uint64_t CellsOf(const GridPlan& plan) { return plan.grids().back().last_cell(); }

TEST(GridMeasure, CountsOnlyValidBoxes) {
  const std::vector<Aabb> boxes = {{{1, 2, 3}, {2, 4, 6}},
                                   {{-kInfinity, 0, 0}, {1, 1, 1}},
                                   {{5, 5, 5}, {4, 4, 4}},
                                   {{0, kNan, 9}, {0, 9, 9}},
                                   {{0, 9, 9}, {0, 9, 9}}};
  const GridMeasure measure = MeasureBoxes(boxes, {100});
  EXPECT_EQ(measure.count(), 2U);
  EXPECT_EQ(measure.low[0], 0) << "the measure uses half of each coordinate";
  EXPECT_EQ(measure.high[0], 0.5F);
  EXPECT_EQ(measure.high[2], 4.5F);
  EXPECT_EQ(measure.shapes[0].max_side[2], 1.5F);
}

TEST(GridMeasure, ClassifiesShapesByEachAxis) {
  const GridMeasure measure = MeasureBoxes(Needles(300), {0.5F});
  EXPECT_EQ(measure.count(), 300U);
  for (const int axis : {0, 1, 2}) {
    const uint32_t along = 2U << (ShapeClasses::kBitsPerAxis * axis);  // 5 > 4 · 0.5
    EXPECT_EQ(measure.shapes[along].count, 100U);
  }
}

TEST(GridMeasure, JoinedPartsEqualTheWhole) {
  const std::vector<Aabb> boxes = Needles(333);
  const GridMeasure whole = MeasureBoxes(boxes, {0.5F});
  GridMeasure joined = MeasureBoxes(std::span(boxes).first(100), {0.5F});
  joined.Join(MeasureBoxes(std::span(boxes).subspan(100), {0.5F}));
  EXPECT_EQ(joined.low[1], whole.low[1]);
  EXPECT_EQ(joined.high[2], whole.high[2]);
  for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) {
    EXPECT_EQ(joined.shapes[k].count, whole.shapes[k].count);
    EXPECT_EQ(joined.shapes[k].max_side[0], whole.shapes[k].max_side[0]);
  }
}

TEST(GroupGrid, HasCellsOfTheLongestBoxIfTheyFit) {
  const CornerBounds bounds = {{0, 0, 0}, {10, 20, 10}};
  const GroupGrid grid = MakeGroupGrid(bounds, {1000, {1, 2, 1}}, 100'000);
  EXPECT_EQ(grid.cells[1], 10U);
  EXPECT_EQ(grid.cells[2], 10U);
  EXPECT_GE(grid.cells[0], 10U) << "cells are finer along the rows";
  EXPECT_GE(grid.reach[1], 2);
}

TEST(GroupGrid, StaysWithinTheMaximumCellsForAnyExtent) {
  for (const double extent : {1e-30, 1.0, 1e10, 1.7e38}) {
    const CornerBounds bounds = {{-extent, 0, -extent}, {extent, 0, extent}};
    const GroupGrid grid = MakeGroupGrid(bounds, {1000, {0, 0, 0}}, 4000);
    EXPECT_LE(grid.cell_count(), 4000U) << extent;
    EXPECT_GE(grid.cell_count(), 1000U) << extent;
    EXPECT_EQ(grid.cells[1], 1U);
  }
}

TEST(GroupGrid, RowsLieAcrossLongBoxes) {
  const CornerBounds bounds = {{0, 0, 0}, {100, 100, 100}};
  EXPECT_EQ(MakeGroupGrid(bounds, {1000, {10, 1, 1}}, 4'000'000).row_axis, 1);
  EXPECT_EQ(MakeGroupGrid(bounds, {1000, {1, 10, 1}}, 4'000'000).row_axis, 2);
  EXPECT_EQ(MakeGroupGrid(bounds, {1000, {1, 1, 10}}, 4'000'000).row_axis, 0);
  EXPECT_EQ(MakeGroupGrid(bounds, {1000, {20, 1, 20}}, 4'000'000).row_axis, 1)
      << "rows of plates lie across both long axes";
}

TEST(GridPlan, HasOneGridForBoxesOfOneSize) {
  EXPECT_EQ(PlanFor(OrdinaryBoxes(2000)).grids().size(), 1U);
  EXPECT_EQ(PlanFor({}).grids().size(), 1U);
}

TEST(GridPlan, HasOneGridForNeedlesOfEachDirection) {
  const GridPlan plan = PlanFor(Needles(3000));
  EXPECT_EQ(plan.grids().size(), 3U);
  int searches = 0;
  for (size_t g = 0; g < 3; ++g) searches += std::popcount(plan.searches()[g]);
  EXPECT_EQ(searches, 3) << "one group of each pair of groups searches";
}

TEST(GridPlan, OneHugeBoxDoesNotCoarsenTheGrid) {
  std::vector<Aabb> boxes = OrdinaryBoxes(2000);
  const uint64_t without = CellsOf(PlanFor(boxes));
  boxes.push_back({{-500, -500, -500}, {500, 500, 500}});
  EXPECT_GE(2 * CellsOf(PlanFor(boxes)), without);
}

TEST(GridPlan, OutliersDoNotCoarsenTheGrid) {
  std::vector<Aabb> boxes = OrdinaryBoxes(2000);
  const GridPlan without = PlanFor(boxes);
  for (const float far : {-1e30F, 1e30F, -kLargest, kLargest}) {
    boxes.push_back({{far, far, far}, {far, far, far}});
  }
  const GridPlan with = PlanFor(boxes);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(with.grids()[0].scale[axis] * 4, without.grids()[0].scale[axis]);
  }
}

// Returns whether the plan stretches the axes for the boxes.
bool IsStretchedFor(GridPlan& plan, const std::vector<Aabb>& boxes) {
  return plan.MakeGrids(nullptr, boxes).is_stretched();
}

std::vector<Aabb> BoxesOf(std::string_view kind, size_t count) {
  const BoxScene scene(kind, count, 7);
  return {scene.boxes().begin(), scene.boxes().end()};
}

TEST(GridPlan, StretchesTheAxesOnlyIfThatSavesTests) {
  for (const std::string_view kind : {"far-crowds", "exponential-spacing"}) {
    GridPlan plan;
    plan.Reset();
    EXPECT_TRUE(IsStretchedFor(plan, BoxesOf(kind, 3000))) << kind;
  }
  for (const std::string_view kind :
       {"brownian", "falling", "all-coincident", "planar", "long-thin", "sizes-1-to-1000"}) {
    GridPlan plan;
    plan.Reset();
    EXPECT_FALSE(IsStretchedFor(plan, BoxesOf(kind, 3000))) << kind;
  }
}

TEST(GridPlan, StretchesTheAxesWhileTheSceneNeedsIt) {
  const std::vector<Aabb> near = OrdinaryBoxes(3000);
  const std::vector<Aabb> far = BoxesOf("far-crowds", 3000);
  constexpr int kFrames = 300;  // more than the interval of the checks
  GridPlan plan;
  plan.Reset();
  EXPECT_FALSE(IsStretchedFor(plan, near));
  for (int frame = 0; frame < kFrames; ++frame) plan.MakeGrids(nullptr, far);
  EXPECT_TRUE(IsStretchedFor(plan, far));
  for (int frame = 0; frame < kFrames; ++frame) plan.MakeGrids(nullptr, near);
  EXPECT_FALSE(IsStretchedFor(plan, near));
}

TEST(GridPlan, GivesTheSameStretchedBoxesOnSeveralThreads) {
  const std::vector<Aabb> boxes = BoxesOf("far-crowds", 20'000);
  const auto pool = MakeThreadPool(3);
  GridPlan alone;
  GridPlan together;
  alone.Reset();
  together.Reset();
  const GridBoxes one = alone.MakeGrids(nullptr, boxes);
  const GridBoxes three = together.MakeGrids(pool.get(), boxes);
  ASSERT_TRUE(one.is_stretched());
  EXPECT_TRUE(std::ranges::equal(one.in_grids, three.in_grids));
}

TEST(GridPlan, AddsAGridForANewShape) {
  std::vector<Aabb> boxes = OrdinaryBoxes(2000);
  GridPlan plan = PlanFor(boxes);
  const uint64_t before = CellsOf(plan);
  boxes.push_back({{-500, -500, -500}, {500, 500, 500}});
  plan.MakeGrids(nullptr, boxes);
  EXPECT_EQ(plan.grids().size(), 2U);
  EXPECT_GE(2 * CellsOf(plan), before);
}

TEST(GridSort, PutsValidBoxesIntoTheCellOfTheirMinCorner) {
  std::vector<Aabb> boxes = OrdinaryBoxes(500);
  boxes[77].min[0] = kNan;
  const GridPlan plan = PlanFor(boxes);
  GridSort sort;
  sort.Sort(nullptr, {boxes, boxes}, plan.grids(), plan.choice());
  const size_t cells = plan.grids().back().last_cell();
  EXPECT_EQ(sort.starts()[0], 0U);
  EXPECT_EQ(sort.starts()[cells], 499U);
  EXPECT_EQ(sort.columns().lanes().id[499], 77U);
  std::vector<uint32_t> ids(sort.columns().lanes().id, sort.columns().lanes().id + 500);
  std::sort(ids.begin(), ids.end());
  std::vector<uint32_t> all(500);
  std::iota(all.begin(), all.end(), 0U);
  EXPECT_EQ(ids, all);
  for (size_t slot = 0; slot < 499; ++slot) {
    EXPECT_EQ(sort.columns().lanes().max[1][slot], boxes[sort.columns().lanes().id[slot]].max[1]);
  }
}

TEST(GridSort, GivesTheSameOrderOnSeveralThreads) {
  const std::vector<Aabb> boxes = Needles(20'000);
  const GridPlan plan = PlanFor(boxes);
  const auto pool = MakeThreadPool(3);
  GridSort alone;
  GridSort together;
  alone.Sort(nullptr, {boxes, boxes}, plan.grids(), plan.choice());
  together.Sort(pool.get(), {boxes, boxes}, plan.grids(), plan.choice());
  EXPECT_TRUE(std::equal(alone.columns().lanes().id, alone.columns().lanes().id + boxes.size(),
                         together.columns().lanes().id));
  EXPECT_TRUE(std::equal(alone.starts(), alone.starts() + CellsOf(plan) + 1, together.starts()));
}

TEST(Grid, OneHugeBoxAddsFewChecks) {
  std::vector<Aabb> boxes = OrdinaryBoxes(3000);
  const uint64_t without = ChecksFor(boxes);
  boxes.push_back({{-1e30F, -1e30F, -1e30F}, {1e30F, 1e30F, 1e30F}});
  EXPECT_LE(ChecksFor(boxes), without + 4 * 3000);
}

TEST(Grid, OutliersAddFewChecks) {
  std::vector<Aabb> boxes = OrdinaryBoxes(3000);
  const uint64_t without = ChecksFor(boxes);
  boxes.push_back({{1e30F, 1e30F, 1e30F}, {1e30F, 1e30F, 1e30F}});
  boxes.push_back({{-kLargest, 0, 0}, {-1e38F, 0, 0}});
  EXPECT_LE(ChecksFor(boxes), 3 * without);
}

TEST(Grid, ChecksFarFewerThanAllPairs) { EXPECT_LE(ChecksFor(OrdinaryBoxes(3000)), 3000U * 100); }

TEST(Grid, ChecksFarFewerThanAllPairsOfNeedles) {
  EXPECT_LE(ChecksFor(Needles(3000)), 3000U * 200);
}

TEST(Grid, ChecksFarFewerThanAllPairsIfSizesSpanThreeDecades) {
  const BoxScene scene("sizes-1-to-1000", 3000, 7);
  EXPECT_LE(ChecksFor({scene.boxes().begin(), scene.boxes().end()}), 3000U * 200);
}

TEST(Grid, FindsPairsInEveryNeighbouringCell) {
  // A small box lies in the middle, and one around each corner, edge and face of the neighbourhood
  // of its cell.
  std::vector<Aabb> boxes = OrdinaryBoxes(400);
  for (const float x : {2.0F, 2.7F, 3.4F}) {
    for (const float y : {2.0F, 2.7F, 3.4F}) {
      for (const float z : {2.0F, 2.7F, 3.4F}) {
        boxes.push_back({{x, y, z}, {x + 0.75F, y + 0.75F, z + 0.75F}});
      }
    }
  }
  ChecksFor(boxes);
}

// At these coordinates rounding makes boxes extend beyond the next cell.
TEST(Grid, FindsPairsFarFromTheOriginOfItsCells) {
  SequentialRandom random(3);
  std::vector<Aabb> boxes;
  for (int i = 0; i < 400; ++i) {
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
      const float base = i % 50 == 0 ? -1e9F : 1e9F;
      box.min[axis] = base + 64 * static_cast<float>(random.Below(12));
      box.max[axis] = box.min[axis] + 64 * static_cast<float>(random.Below(3));
    }
    boxes.push_back(box);
  }
  ChecksFor(boxes);
}

}  // namespace
}  // namespace sweepstake
