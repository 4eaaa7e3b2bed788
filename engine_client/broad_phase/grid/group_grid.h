// The grid over one group of boxes: which cell the min corner of a box lies in, and which cells the
// min corners of its partners can lie in.
//
// A box is kept once, in the cell of its min corner. A partner's min corner is no further along
// than the box's max corner and no further back than its min corner less the longest box of the
// group, so that a box finds its partners in a block of cells, row by row. A cell number is a
// monotone function of the coordinate, clamped to the grid: that alone makes the search sound,
// whatever rounding, overflow and outliers do. Coordinates are halved inside, so that no difference
// of two finite floats overflows.
//
// Values, safe to copy. Cost: constant, below 1 µs.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sweepstake {

struct GroupGrid {
  float origin[3] = {};            // half the coordinate at which cell 0 starts, per axis
  float scale[3] = {1, 1, 1};      // cells per half unit
  float reach[3] = {};             // half the longest box of the group, rounded up
  uint32_t cells[3] = {1, 1, 1};   // along x, y and z
  uint32_t stride[3] = {1, 1, 1};  // from one cell to the next along an axis; 1 along the rows
  uint32_t first_cell = 0;         // its first cell among those of all groups
  int row_axis = 0;

  // 0: the axis along the rows, 1 and 2 the others.
  size_t AxisOf(int index) const { return static_cast<size_t>((row_axis + index) % 3); }
  uint32_t cell_count() const { return cells[0] * cells[1] * cells[2]; }
  uint32_t last_cell() const { return first_cell + cell_count(); }
};

// Half coordinates of the min corners of all boxes that take part. An empty scene has low > high.
struct CornerBounds {
  double low[3];
  double high[3];
};

// What one group is: how many boxes, and half the longest of them along each axis.
struct GroupShape {
  uint32_t count = 0;
  float longest[3] = {};

  // As if the boxes of both were one group.
  void Add(const GroupShape& other);
};

// A few per box: empty ones cost little, boxes that share one are tested against one another.
constexpr size_t MostCellsFor(size_t box_count) { return 4 * box_count + 256; }

// Cells that the longest box of the group asks for; may be beyond any integer.
double CellsWanted(const CornerBounds& bounds, const GroupShape& shape);

// A grid for the group with cells as small as its longest box, or larger where more than
// `most_cells` would be needed. REQUIRES: most_cells > 0.
GroupGrid MakeGroupGrid(const CornerBounds& bounds, const GroupShape& shape, size_t most_cells);

}  // namespace sweepstake
