// What is Grid's own: cells that neither a huge box nor an outlier can spoil.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "engine_client/broad_phase/grid_layout.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/box_scenes.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::MakeOrThrow;
using test_support::Verdict;

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<Aabb> OrdinaryBoxes(size_t count) {
  const BoxScene scene("brownian", count, 7);
  return {scene.boxes().begin(), scene.boxes().end()};
}

struct Laid {
  BoxSpread spread;
  float side;
  GridLayout layout;
};

Laid LayOut(const std::vector<Aabb>& boxes) {
  SoaBoxes lanes;
  lanes.Gather(boxes);
  Laid laid;
  MeasureSpread(lanes.Lanes(), laid.spread);
  laid.side = ChooseOrdinarySide(laid.spread);
  laid.layout = LayOutGrid(lanes.Lanes(), laid.spread, laid.side, 8 * boxes.size() + 512);
  return laid;
}

uint64_t ChecksFor(const std::vector<Aabb>& boxes) {
  const auto grid = MakeOrThrow("Grid");
  PairBuffer pairs;
  grid->Build(boxes);
  EXPECT_EQ(Verdict(*grid, boxes, pairs), "");
  return grid->aabb_check_count();
}

TEST(BoxSpread, CountsOnlyBoxesThatTakePart) {
  const std::vector<Aabb> boxes = {{{1, 2, 3}, {2, 4, 6}},
                                   {{-kInfinity, 0, 0}, {1, 1, 1}},
                                   {{5, 5, 5}, {4, 4, 4}},
                                   {{0, 9, 9}, {0, 9, 9}}};
  const Laid laid = LayOut(boxes);
  EXPECT_EQ(laid.spread.count, 2U);
  EXPECT_EQ(laid.spread.low[0], 0);
  EXPECT_EQ(laid.spread.high[0], 1);
  EXPECT_EQ(laid.spread.high[2], 9);
  EXPECT_EQ(laid.spread.longest_side, 3);
  size_t counted = 0;
  for (const uint32_t count : laid.spread.side_counts) counted += count;
  EXPECT_EQ(counted, 2U);
}

TEST(GridLayout, FitsTheLargestBoxWhereSizesAreAlike) {
  const Laid laid = LayOut(OrdinaryBoxes(2000));
  EXPECT_EQ(laid.side, laid.spread.longest_side);
  EXPECT_GT(laid.layout.cells[0] * laid.layout.cells[1] * laid.layout.cells[2], 400U);
}

TEST(GridLayout, IsNotCoarsenedByOneHugeBox) {
  std::vector<Aabb> boxes = OrdinaryBoxes(2000);
  const Laid without = LayOut(boxes);
  boxes.push_back({{-500, -500, -500}, {500, 500, 500}});
  const Laid with = LayOut(boxes);
  EXPECT_LE(with.side, without.side * 1.2F);
}

TEST(GridLayout, DividesTheBulkFinelyDespiteOutliers) {
  std::vector<Aabb> boxes = OrdinaryBoxes(2000);
  const Laid without = LayOut(boxes);
  for (const float far : {-1e30F, 1e30F, -kLargest, kLargest}) {
    boxes.push_back({{far, far, far}, {far, far, far}});
  }
  const Laid with = LayOut(boxes);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(with.layout.cells[axis] * 4, without.layout.cells[axis]);
  }
  EXPECT_LE(with.layout.bordered_cells(), 8 * boxes.size() + 512);
}

TEST(GridLayout, KeepsToItsMostCellsWhateverTheExtent) {
  std::vector<Aabb> boxes;
  for (int i = -500; i < 500; ++i) {
    const float x = static_cast<float>(i) * (kLargest / 1000);
    boxes.push_back({{x, 0, 0}, {x, 0, 0}});
  }
  const Laid laid = LayOut(boxes);
  EXPECT_LE(laid.layout.bordered_cells(), 8 * boxes.size() + 512);
  EXPECT_GT(laid.layout.cells[0], 100U);
}

TEST(GridLayout, NumbersCellsInTheOrderOfCoordinates) {
  for (const Laid& laid :
       {LayOut(OrdinaryBoxes(500)),
        LayOut({{{-kLargest, 0, 0}, {kLargest, 1e-40F, 0}}, {{0, 0, 0}, {0, 0, 0}}}), LayOut({})}) {
    uint32_t previous = 0;
    for (const float x : {-kLargest, -1e30F, -100.0F, -1.0F, -1e-40F, 0.0F, 1e-40F, 0.5F, 3.0F,
                          7.0F, 1e30F, kLargest}) {
      const uint32_t cell = laid.layout.CellOf(x, 0);
      EXPECT_GE(cell, previous) << "at " << x;
      EXPECT_LT(cell, laid.layout.cells[0]);
      previous = cell;
    }
  }
}

TEST(Grid, ComparesLittleMoreForOneHugeBox) {
  std::vector<Aabb> boxes = OrdinaryBoxes(3000);
  const uint64_t without = ChecksFor(boxes);
  boxes.push_back({{-1e30F, -1e30F, -1e30F}, {1e30F, 1e30F, 1e30F}});
  EXPECT_LE(ChecksFor(boxes), without + 3 * 3000);
}

TEST(Grid, ComparesLittleMoreForOutliers) {
  std::vector<Aabb> boxes = OrdinaryBoxes(3000);
  const uint64_t without = ChecksFor(boxes);
  boxes.push_back({{1e30F, 1e30F, 1e30F}, {1e30F, 1e30F, 1e30F}});
  boxes.push_back({{-kLargest, 0, 0}, {-1e38F, 0, 0}});
  EXPECT_LE(ChecksFor(boxes), 3 * without);
}

TEST(Grid, ComparesFarFewerThanAllPairs) { EXPECT_LE(ChecksFor(OrdinaryBoxes(3000)), 3000U * 200); }

TEST(Grid, FindsPartnersInEveryNeighbouringCell) {
  // A small box in the middle, and one around each corner, edge and face of its cell's
  // surroundings.
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

}  // namespace
}  // namespace sweepstake
