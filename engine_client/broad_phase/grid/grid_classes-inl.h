// Classes of shape and the cells of min corners, a register at a time, for every target of Highway.
// Include after hwy/foreach_target.h.
#if defined(SWEEPSTAKE_GRID_CLASSES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_GRID_CLASSES_INL_H_
#undef SWEEPSTAKE_GRID_CLASSES_INL_H_
#else
#define SWEEPSTAKE_GRID_CLASSES_INL_H_
#endif

#include <cstdint>
#include <span>

#include "engine_client/broad_phase/grid/grid_boxes-inl.h"
#include "engine_client/broad_phase/grid/grid_measure.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Class of half a side on one axis, at its place among the axes.
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

template <class D, class V>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> ClassesOfSides(D d, const ShapeClasses& classes, V x, V y,
                                                         V z) {
  return hn::Or(
      ClassesOnAxis(d, classes.threshold, 0, x),
      hn::Or(ClassesOnAxis(d, classes.threshold, 1, y), ClassesOnAxis(d, classes.threshold, 2, z)));
}

// Cell of each min corner.
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
