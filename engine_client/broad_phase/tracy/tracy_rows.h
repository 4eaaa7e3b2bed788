// The rows of cells of Tracy's grids. Each row has a list of boxes (tracy_lists.h). The rows of all
// grids are numbered consecutively. One more row, the last one, holds the boxes that are too long
// for the grid of their group.
//
// Plain values; the kernel is dispatched at run time once per call.
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

// Grids that are kept for several frames, and their rows.
struct RowGrids {
  static constexpr size_t kMaxGroups = GridPlan::kMaxGroups + 1;

  std::array<GroupGrid, kMaxGroups> grids;  // the grids; the last is one cell for the long boxes
  std::array<GroupGrid, kMaxGroups> row_grids;  // `grids` with each row as one cell
  std::array<uint32_t, kMaxGroups> searches;
  size_t group_count = 0;  // the number of groups, including the group of the long boxes
  GroupChoice choice;

  RowGrids() = default;
  explicit RowGrids(const GridPlan& plan);

  uint32_t row_count() const { return long_row() + 1; }
  // Returns the row of the long boxes.
  uint32_t long_row() const { return row_grids[group_count - 1].first_cell; }
  std::span<const GroupGrid> ordinary_row_grids() const {
    return {row_grids.data(), group_count - 1};
  }
};

// The row of a box that is not in a list, since it is invalid or new.
constexpr uint32_t kNoRow = 0xFFFFFFFF;

// Lists in `moved`, in ascending order, the indices of the boxes whose row differs from their row
// in `rows`. Writes their new rows to `new_rows` and returns their number. REQUIRES: `moved` and
// `new_rows` have room for one register more than there are boxes, and `rows` can be read up to the
// same length.
size_t FindMovedRows(std::span<const Aabb> boxes, const RowGrids& grids, const uint32_t* rows,
                     uint32_t* moved, uint32_t* new_rows);

}  // namespace sweepstake
