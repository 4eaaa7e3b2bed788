// The grid of one group of boxes. It gives the cell that holds the min corner of a box, and the
// cells that can hold the min corners of its partners.
//
// A box is stored once, in the cell of its min corner. A partner's min corner lies between two
// points: the box's min corner minus the maximum side of the group, and the box's max corner. A box
// thus finds its partners in a block of cells, row by row. The cell number is a monotone function
// of the coordinate, clamped to the grid. This alone makes the search correct despite rounding,
// overflow and outliers. Coordinates are halved internally, so that no difference of two finite
// floats overflows.
//
// Plain values, safe to copy. Cost: constant.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace sweepstake {

struct GroupGrid {
  // Cells are this many times shorter along the rows. A row is searched as one range of slots, so
  // that more cells in it do not cost more searches.
  static constexpr int kRowCells = 2;

  float origin[3] = {};            // half the coordinate at which cell 0 starts, per axis
  float scale[3] = {1, 1, 1};      // the number of cells per half unit
  float reach[3] = {};             // half the maximum side of the group, rounded up
  uint32_t cells[3] = {1, 1, 1};   // the number of cells along x, y and z
  uint32_t stride[3] = {1, 1, 1};  // the step between neighbouring cells; 1 along the rows
  uint32_t first_cell = 0;         // the first cell's number; numbers continue from grid to grid
  int row_axis = 0;

  // Returns the axis along the rows for index 0, and the other axes for 1 and 2.
  size_t AxisOf(int index) const { return static_cast<size_t>((row_axis + index) % 3); }
  // Returns the cell on one axis that holds half a coordinate, or the nearest cell.
  uint32_t CellAt(int axis, float halved) const {
    const float cell = (halved - origin[axis]) * scale[axis];
    return static_cast<uint32_t>(
        std::min(std::max(cell, 0.0F), static_cast<float>(cells[axis] - 1)));
  }
  uint32_t cell_count() const { return cells[0] * cells[1] * cells[2]; }
  uint32_t last_cell() const { return first_cell + cell_count(); }
};

// The bounds of the min corners of all valid boxes, with halved coordinates. An empty scene has low
// > high.
struct CornerBounds {
  double low[3];
  double high[3];
};

// One group: its number of boxes, and half their maximum side on each axis.
struct GroupShape {
  uint32_t count = 0;
  float max_side[3] = {};

  // Merges another group into this one.
  void Add(const GroupShape& other);
};

// Returns the maximum number of cells for a number of boxes: a few cells per box. Empty cells cost
// little, but more boxes in a cell mean more tests between them.
constexpr size_t MaxCellCount(size_t box_count) { return 4 * box_count + 256; }

// Returns how many cells the grid has if its cells are as small as the group's maximum sides. The
// number may exceed the range of any integer type.
double CellsWanted(const CornerBounds& bounds, const GroupShape& shape);

// Makes a grid for the group with cells as small as its maximum sides, or larger if that needs more
// than `max_cells` cells. REQUIRES: max_cells > 0.
GroupGrid MakeGroupGrid(const CornerBounds& bounds, const GroupShape& shape, size_t max_cells);

}  // namespace sweepstake
