#include "engine_client/broad_phase/grid/group_grid.h"

#include <algorithm>
#include <cmath>

namespace sweepstake {
namespace {

// The factor by which a cell is longer than a box, so that rounding does not push a box out of it.
constexpr double kCellSlack = 1.0001;
// The minimum side of a cell, in world units. It keeps the scale finite.
constexpr double kMinCellSide = 1e-36;
// The number of steps of the bisection that finds log2 of the cell size. The last step is below
// 0.01 for any scene.
constexpr int kBisectionCount = 14;
// A float holds every cell number up to this limit exactly.
constexpr double kMaxCellsPerAxis = 1 << 22;

struct Cells {
  double side[3];
  double count[3];

  double Product() const { return count[0] * count[1] * count[2]; }
};

Cells Divide(const CornerBounds& bounds, const GroupShape& shape, double min_side) {
  Cells cells{};
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = std::max(0.0, bounds.high[axis] - bounds.low[axis]);
    const double wanted = std::max({kCellSlack * shape.max_side[axis], min_side, kMinCellSide});
    cells.side[axis] = std::max(wanted, extent / kMaxCellsPerAxis);
    cells.count[axis] = std::floor(extent / cells.side[axis]) + 1;
  }
  return cells;
}

// Chooses the smallest cells with which the grid has at most `max_count` cells, and returns the
// resulting division.
Cells DivideInto(const CornerBounds& bounds, const GroupShape& shape, double max_count) {
  const Cells finest = Divide(bounds, shape, 0);
  if (finest.Product() <= max_count) return finest;
  double low = 0;
  double high = 0;
  for (int axis = 0; axis < 3; ++axis) {
    high = std::max(high, std::log2(std::max(1e-37, bounds.high[axis] - bounds.low[axis])) + 1);
    low = std::min(low, std::log2(finest.side[axis]));
  }
  for (int step = 0; step < kBisectionCount; ++step) {
    const double middle = (low + high) / 2;
    (Divide(bounds, shape, std::exp2(middle)).Product() > max_count ? low : high) = middle;
  }
  return Divide(bounds, shape, std::exp2(high));
}

// Returns the axis along which the rows of cells run: normally the one with the shortest side,
// along which a long box crosses the most cells. Needles have two short sides; for them it is the
// axis that follows the long one in cyclic order. Of any two groups of needles with different
// directions, one then lies along the rows of the other's grid.
int ChooseRowAxis(const double (&side)[3]) {
  const int shortest = static_cast<int>(std::min_element(side, side + 3) - side);
  const int longest = static_cast<int>(std::max_element(side, side + 3) - side);
  const int middle = 3 - shortest - longest;
  if (shortest == longest) return 0;
  if (side[longest] > 2 * side[middle]) return (longest + 1) % 3;
  if (side[middle] > 2 * side[shortest]) return shortest;
  return 0;
}

}  // namespace

void GroupShape::Add(const GroupShape& other) {
  count += other.count;
  for (int axis = 0; axis < 3; ++axis)
    max_side[axis] = std::max(max_side[axis], other.max_side[axis]);
}

double CellsWanted(const CornerBounds& bounds, const GroupShape& shape) {
  return GroupGrid::kRowCells * Divide(bounds, shape, 0).Product();
}

GroupGrid MakeGroupGrid(const CornerBounds& bounds, const GroupShape& shape, size_t max_cells) {
  GroupGrid grid;
  if (bounds.low[0] > bounds.high[0]) return grid;
  Cells cells = DivideInto(bounds, shape,
                           std::max(1.0, static_cast<double>(max_cells) / GroupGrid::kRowCells));
  grid.row_axis = ChooseRowAxis(cells.side);
  cells.side[grid.row_axis] /= GroupGrid::kRowCells;
  cells.count[grid.row_axis] *= GroupGrid::kRowCells;
  uint32_t stride = 1;
  for (int k = 0; k < 3; ++k) {
    const int axis = (grid.row_axis + k) % 3;
    grid.origin[axis] = static_cast<float>(bounds.low[axis]);
    grid.scale[axis] = static_cast<float>(1 / cells.side[axis]);
    grid.reach[axis] = std::nextafter(shape.max_side[axis] * 1.000001F + 1e-37F, INFINITY);
    grid.cells[axis] = static_cast<uint32_t>(cells.count[axis]);
    grid.stride[axis] = stride;
    stride *= grid.cells[axis];
  }
  return grid;
}

}  // namespace sweepstake
