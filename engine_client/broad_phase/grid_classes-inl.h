// Classes of shape, a register at a time, for every target of Highway. Include after
// hwy/foreach_target.h.
#if defined(SWEEPSTAKE_GRID_CLASSES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_GRID_CLASSES_INL_H_
#undef SWEEPSTAKE_GRID_CLASSES_INL_H_
#else
#define SWEEPSTAKE_GRID_CLASSES_INL_H_
#endif

#include <cstdint>

#include "engine_client/broad_phase/grid_measure.h"
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

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
