// Rows of cells: the lists of the Tracy family. All grids together number their rows one after the
// other; behind the last row is the list of boxes that are too long for the grid of their group.
//
// Values; the kernel is chosen at run time once per call.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// Grids that are kept, and the rows they have.
struct RowGrids {
  static constexpr size_t kMostGroups = GridPlan::kMostGroups + 1;

  std::array<GroupGrid, kMostGroups> grids;      // the last one holds too long boxes in one cell
  std::array<GroupGrid, kMostGroups> row_grids;  // the same with rows for cells
  std::array<uint32_t, kMostGroups> looks_into;
  size_t group_count = 0;  // the group of too long boxes included
  GroupChoice choice;

  RowGrids() = default;
  explicit RowGrids(const GridPlan& plan);

  uint32_t row_count() const { return long_row() + 1; }
  // Of the boxes that are too long.
  uint32_t long_row() const { return row_grids[group_count - 1].first_cell; }
  std::span<const GroupGrid> ordinary_row_grids() const {
    return {row_grids.data(), group_count - 1};
  }
};

// Of a box in no row: it does not take part, or is new.
constexpr uint32_t kNoRow = 0xFFFFFFFF;

// Finds the row of each box and lists the boxes (relative to the first) whose row is not the one in
// `rows`, in order; returns how many. Writes the rows of the listed ones to `new_rows`. Both need
// room for a register more than there are boxes, and `rows` is read as far.
size_t FindMoved(std::span<const Aabb> boxes, const RowGrids& grids, const uint32_t* rows,
                 uint32_t* moved, uint32_t* new_rows);

}  // namespace sweepstake
