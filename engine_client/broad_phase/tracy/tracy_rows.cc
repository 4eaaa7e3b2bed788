#include "engine_client/broad_phase/tracy/tracy_rows.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/tracy/tracy_rows.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Returns the row of each box in one grid, or `long_row` if the box does not fit its cells.
template <class D, class V>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> RowOfBox(D d, const GroupGrid& grid, int32_t long_row,
                                                   V x, V y, V z, V side_x, V side_y, V side_z) {
  const hn::RebindToSigned<D> di;
  const auto fits = hn::And(hn::Le(side_x, hn::Set(d, grid.reach[0])),
                            hn::And(hn::Le(side_y, hn::Set(d, grid.reach[1])),
                                    hn::Le(side_z, hn::Set(d, grid.reach[2]))));
  return hn::IfThenElse(hn::RebindMask(di, fits), CellOfCorner(d, grid, x, y, z),
                        hn::Set(di, long_row));
}

// Does the work of FindMovedRows, a register of boxes at a time.
size_t Moved(std::span<const Aabb> boxes, const RowGrids& rows, const uint32_t* kept,
             uint32_t* moved, uint32_t* new_rows) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto grids = rows.ordinary_row_grids();
  const auto long_row = static_cast<int32_t>(rows.long_row());
  const auto* const group_of_class = reinterpret_cast<const int32_t*>(rows.choice.group_of_class);
  size_t count = 0;
  const auto list_moved = [&](size_t at, auto valid, auto x, auto y, auto z, auto max_x, auto max_y,
                              auto max_z) HWY_ATTR {
    // Computes the sides of the boxes, one box per lane.
    const auto side_x = hn::Sub(max_x, x);
    const auto side_y = hn::Sub(max_y, y);
    const auto side_z = hn::Sub(max_z, z);
    // Selects the row in the grid of the box's group.
    auto row = hn::Zero(di);
    if (grids.size() == 1) {
      row = RowOfBox(d, grids[0], long_row, x, y, z, side_x, side_y, side_z);
    } else {
      const auto classes = ClassesOfSides(d, rows.choice.classes, side_x, side_y, side_z);
      const auto groups = hn::GatherIndex(di, group_of_class, classes);
      for (size_t group = 0; group < grids.size(); ++group) {
        const auto here = hn::Eq(groups, hn::Set(di, static_cast<int32_t>(group)));
        if (hn::AllFalse(di, here)) continue;
        row = hn::IfThenElse(
            here, RowOfBox(d, grids[group], long_row, x, y, z, side_x, side_y, side_z), row);
      }
    }
    // An invalid box has no row.
    row = hn::IfThenElse(hn::RebindMask(di, valid), row, hn::Set(di, static_cast<int32_t>(kNoRow)));
    // Compares the rows with the previous rows.
    const auto inside = hn::FirstN(di, boxes.size() - at);
    const auto old = hn::LoadU(di, reinterpret_cast<const int32_t*>(kept + at));
    const auto changed = hn::And(inside, hn::Ne(row, old));
    if (hn::AllFalse(di, changed)) return;
    // Lists the boxes whose row has changed, with their new rows.
    const auto index = hn::Iota(du, static_cast<uint32_t>(at));
    const auto mask = hn::RebindMask(du, changed);
    hn::StoreU(CompressLanes(index, mask), du, moved + count);
    hn::StoreU(CompressLanes(hn::BitCast(du, row), mask), du, new_rows + count);
    count += hn::CountTrue(du, mask);
  };
  ForEachHalved(d, boxes, list_moved);
  return count;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Moved);

RowGrids::RowGrids(const GridPlan& plan) : choice(plan.choice()) {
  group_count = plan.grids().size() + 1;
  std::copy(plan.grids().begin(), plan.grids().end(), grids.begin());
  std::copy_n(plan.searches(), group_count - 1, searches.begin());
  GroupGrid& long_grid = grids[group_count - 1];
  long_grid = GroupGrid();
  long_grid.first_cell = grids[group_count - 2].last_cell();
  std::fill_n(long_grid.reach, 3, std::numeric_limits<float>::max() / 2);
  searches[group_count - 1] = (1U << (group_count - 1)) - 1;
  uint32_t row = 0;
  for (size_t group = 0; group < group_count; ++group) {
    GroupGrid& rows = row_grids[group];
    rows = grids[group];
    rows.stride[rows.AxisOf(0)] = 0;
    rows.stride[rows.AxisOf(1)] = 1;
    rows.stride[rows.AxisOf(2)] = rows.cells[rows.AxisOf(1)];
    rows.first_cell = row;
    row += rows.cells[rows.AxisOf(1)] * rows.cells[rows.AxisOf(2)];
  }
}

size_t FindMovedRows(std::span<const Aabb> boxes, const RowGrids& grids, const uint32_t* rows,
                     uint32_t* moved, uint32_t* new_rows) {
  return HWY_DYNAMIC_DISPATCH(Moved)(boxes, grids, rows, moved, new_rows);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
