// Functions that load registers of boxes in the caller's order and compute their shape classes and
// cells. All coordinates are halved first, so that the difference of two does not overflow.
// Compiled for every target of Highway; include after hwy/foreach_target.h.
#if defined(SWEEPSTAKE_GRID_BOXES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_GRID_BOXES_INL_H_
#undef SWEEPSTAKE_GRID_BOXES_INL_H_
#else
#define SWEEPSTAKE_GRID_BOXES_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "hwy/highway.h"
#include "sweepstake/aabb.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Halves the coordinates on one axis and returns the lanes whose box is valid there; NaN fails
// every comparison.
template <class D, class V>
HWY_INLINE hn::Mask<D> HalveAxis(D d, V& min, V& max) {
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  const auto finite = hn::And(hn::Ge(min, hn::Neg(limit)), hn::Le(max, limit));
  const auto present = hn::And(finite, hn::Le(min, max));
  min = hn::Mul(min, hn::Set(d, 0.5F));
  max = hn::Mul(max, hn::Set(d, 0.5F));
  return present;
}

// Loads the coordinates of as many boxes as there are lanes. The results are reference parameters,
// since a struct cannot hold vectors whose size the compiler does not know (SVE).
template <class D, class V>
HWY_INLINE void LoadBoxes(D d, const Aabb* boxes, V& min_x, V& min_y, V& min_z, V& max_x, V& max_y,
                          V& max_z) {
#if HWY_TARGET == HWY_SCALAR
  min_x = hn::Set(d, boxes->min[0]);
  min_y = hn::Set(d, boxes->min[1]);
  min_z = hn::Set(d, boxes->min[2]);
  max_x = hn::Set(d, boxes->max[0]);
  max_y = hn::Set(d, boxes->max[1]);
  max_z = hn::Set(d, boxes->max[2]);
#else
  V x0;
  V y0;
  V z0;
  V x1;
  V y1;
  V z1;
  hn::LoadInterleaved3(d, boxes->min, x0, y0, z0);
  hn::LoadInterleaved3(d, boxes->min + 3 * hn::Lanes(d), x1, y1, z1);
  min_x = hn::ConcatEven(d, x1, x0);
  min_y = hn::ConcatEven(d, y1, y0);
  min_z = hn::ConcatEven(d, z1, z0);
  max_x = hn::ConcatOdd(d, x1, x0);
  max_y = hn::ConcatOdd(d, y1, y0);
  max_z = hn::ConcatOdd(d, z1, z0);
#endif
}

// Calls action(boxes, index) for each run of boxes that fills a register. The last run is filled up
// with invalid boxes. The action is called at one place, so that it is inlined: gcc does not clear
// the registers' upper halves after a call with vectors as arguments, and then all SSE code that
// follows takes twice as long.
template <class D, class Action>
HWY_INLINE void ForEachRegister(D d, std::span<const Aabb> boxes, const Action& action) {
  const size_t step = hn::Lanes(d);
  Aabb last[HWY_MAX_BYTES / sizeof(float)];
  for (size_t at = 0; at < boxes.size(); at += step) {
    const Aabb* from = boxes.data() + at;
    if (at + step > boxes.size()) {
      constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
      std::fill_n(last, step, Aabb{{kNan, kNan, kNan}, {kNan, kNan, kNan}});
      std::copy(boxes.begin() + static_cast<std::ptrdiff_t>(at), boxes.end(), last);
      from = last;
    }
    action(from, at);
  }
}

// Calls action(index, valid, min_x, min_y, min_z, max_x, max_y, max_z) for each run of boxes that
// fills a register, with halved coordinates. `valid` marks the lanes whose box is valid.
template <class D, class Action>
HWY_INLINE void ForEachHalved(D d, std::span<const Aabb> boxes, const Action& action) {
  // A copy of the action: through a reference, each access to its variables would take two steps.
  ForEachRegister(d, boxes, [d, action](const Aabb* from, size_t at) HWY_ATTR {
    auto x = hn::Zero(d);
    auto y = x;
    auto z = x;
    auto max_x = x;
    auto max_y = x;
    auto max_z = x;
    LoadBoxes(d, from, x, y, z, max_x, max_y, max_z);
    const auto on_x = HalveAxis(d, x, max_x);
    const auto on_y = HalveAxis(d, y, max_y);
    const auto valid = hn::And(hn::And(on_x, on_y), HalveAxis(d, z, max_z));
    action(at, valid, x, y, z, max_x, max_y, max_z);
  });
}

// Returns the cell numbers of halved coordinates on one axis. Invalid boxes get arbitrary cells.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> CellsAt(D d, const GroupGrid& grid, size_t axis,
                                                  hn::Vec<D> halved) {
  const auto from_origin = hn::Sub(halved, hn::Set(d, grid.origin[axis]));
  const auto cell = hn::Mul(from_origin, hn::Set(d, grid.scale[axis]));
  const auto last = hn::Set(d, static_cast<float>(grid.cells[axis] - 1));
  const hn::RebindToSigned<D> di;
  return hn::ConvertTo(di, hn::Min(hn::Max(cell, hn::Zero(d)), last));
}

// Returns the shape class (grid_measure.h) of halved sides on one axis, shifted to the bits of that
// axis.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> ClassesOnAxis(D d, float threshold, int axis,
                                                        hn::Vec<D> side) {
  const hn::RebindToSigned<D> di;
  const auto one = hn::Set(di, int32_t{1} << (ShapeClasses::kBitsPerAxis * axis));
  auto classes = hn::Zero(di);
  for (int k = 0; k < 3; ++k, threshold *= ShapeClasses::kRatio) {
    const auto longer = hn::RebindMask(di, hn::Gt(side, hn::Set(d, threshold)));
    classes = hn::Add(classes, hn::IfThenElseZero(longer, one));
  }
  return classes;
}

// Returns the shape class of each box from its halved sides.
template <class D, class V>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> ClassesOfSides(D d, const ShapeClasses& classes, V x, V y,
                                                         V z) {
  return hn::Or(
      ClassesOnAxis(d, classes.threshold, 0, x),
      hn::Or(ClassesOnAxis(d, classes.threshold, 1, y), ClassesOnAxis(d, classes.threshold, 2, z)));
}

// Returns the cell of each min corner.
template <class D, class V>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> CellOfCorner(D d, const GroupGrid& grid, V x, V y, V z) {
  const hn::RebindToSigned<D> di;
  const auto along = [&](size_t axis, auto corner) HWY_ATTR {
    const auto stride = hn::Set(di, static_cast<int32_t>(grid.stride[axis]));
    return hn::Mul(CellsAt(d, grid, axis, corner), stride);
  };
  const auto in_grid = hn::Add(along(0, x), hn::Add(along(1, y), along(2, z)));
  return hn::Add(in_grid, hn::Set(di, static_cast<int32_t>(grid.first_cell)));
}

// Returns the cell of each min corner in the grid of the box's group.
template <class D, class V>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> CellInGroup(D d, std::span<const GroupGrid> grids,
                                                      hn::Vec<hn::RebindToSigned<D>> groups, V x,
                                                      V y, V z) {
  const hn::RebindToSigned<D> di;
  auto cells = hn::Zero(di);
  for (size_t group = 0; group < grids.size(); ++group) {
    const auto here = hn::Eq(groups, hn::Set(di, static_cast<int32_t>(group)));
    if (hn::AllFalse(di, here)) continue;
    cells = hn::IfThenElse(here, CellOfCorner(d, grids[group], x, y, z), cells);
  }
  return cells;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
