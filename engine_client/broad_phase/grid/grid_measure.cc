#include "engine_client/broad_phase/grid/grid_measure.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/common/stop_poll.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid/grid_measure.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Adds the valid boxes of a register to the counts and maximum sides of their classes.
template <class D>
HWY_INLINE void CountShapes(D d, hn::Vec<hn::RebindToSigned<D>> classes, hn::Mask<D> valid,
                            hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z, GridMeasure& measure) {
  const hn::RebindToSigned<D> di;
  HWY_ALIGN int32_t class_of[HWY_MAX_BYTES / sizeof(float)];
  HWY_ALIGN float sides[3][HWY_MAX_BYTES / sizeof(float)];
  hn::Store(hn::IfThenElse(hn::RebindMask(di, valid), classes, hn::Set(di, -1)), di, class_of);
  hn::Store(x, d, sides[0]);
  hn::Store(y, d, sides[1]);
  hn::Store(z, d, sides[2]);
  for (size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    if (class_of[lane] < 0) continue;
    GroupShape& shape = measure.shapes[static_cast<size_t>(class_of[lane])];
    ++shape.count;
    for (size_t k = 0; k < 3; ++k) shape.max_side[k] = std::max(shape.max_side[k], sides[k][lane]);
  }
}

void Measure(std::span<const Aabb> boxes, const ShapeClasses& classes, GridMeasure& measure) {
  const HWY_FULL(float) d;
  // Starts with empty bounds, and with no boxes counted in class 0 (size step 0 on all axes).
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  auto low_x = limit;
  auto low_y = limit;
  auto low_z = limit;
  auto high_x = hn::Neg(limit);
  auto high_y = high_x;
  auto high_z = high_x;
  auto longest_x = hn::Zero(d);
  auto longest_y = longest_x;
  auto longest_z = longest_x;
  uint32_t first_class_count = 0;
  const auto measure_boxes = [&](size_t, auto valid, auto x, auto y, auto z, auto max_x, auto max_y,
                                 auto max_z) HWY_ATTR {
    // Extends the bounds of the min corners.
    low_x = hn::Min(low_x, hn::IfThenElse(valid, x, limit));
    low_y = hn::Min(low_y, hn::IfThenElse(valid, y, limit));
    low_z = hn::Min(low_z, hn::IfThenElse(valid, z, limit));
    high_x = hn::Max(high_x, hn::IfThenElse(valid, x, hn::Neg(limit)));
    high_y = hn::Max(high_y, hn::IfThenElse(valid, y, hn::Neg(limit)));
    high_z = hn::Max(high_z, hn::IfThenElse(valid, z, hn::Neg(limit)));
    // Most scenes have boxes of class 0 only. If all boxes of a register are of class 0, their
    // classes are not computed one by one.
    const auto side_x = hn::IfThenElseZero(valid, hn::Sub(max_x, x));
    const auto side_y = hn::IfThenElseZero(valid, hn::Sub(max_y, y));
    const auto side_z = hn::IfThenElseZero(valid, hn::Sub(max_z, z));
    const auto longest = hn::Max(side_x, hn::Max(side_y, side_z));
    if (hn::AllTrue(d, hn::Le(longest, hn::Set(d, classes.threshold)))) {
      longest_x = hn::Max(longest_x, side_x);
      longest_y = hn::Max(longest_y, side_y);
      longest_z = hn::Max(longest_z, side_z);
      first_class_count += static_cast<uint32_t>(hn::CountTrue(d, valid));
      return;
    }
    // Otherwise adds each box to the count of its own class.
    const auto shapes = ClassesOfSides(d, classes, side_x, side_y, side_z);
    CountShapes(d, shapes, valid, side_x, side_y, side_z, measure);
  };
  ForEachHalved(d, boxes, measure_boxes);
  // Reduces the registers to one value each and adds the result for class 0 to `measure`.
  const auto low = [&](auto v) HWY_ATTR { return hn::GetLane(hn::MinOfLanes(d, v)); };
  const auto high = [&](auto v) HWY_ATTR { return hn::GetLane(hn::MaxOfLanes(d, v)); };
  GridMeasure measured;
  measured.low[0] = low(low_x);
  measured.low[1] = low(low_y);
  measured.low[2] = low(low_z);
  measured.high[0] = high(high_x);
  measured.high[1] = high(high_y);
  measured.high[2] = high(high_z);
  measured.shapes[0] = {first_class_count, {high(longest_x), high(longest_y), high(longest_z)}};
  measure.Join(measured);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Measure);

GridMeasure::GridMeasure() {
  std::fill_n(low, 3, std::numeric_limits<float>::max());
  std::fill_n(high, 3, -std::numeric_limits<float>::max());
}

void GridMeasure::Join(const GridMeasure& other) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
  for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) shapes[k].Add(other.shapes[k]);
}

uint32_t GridMeasure::count() const {
  uint32_t sum = 0;
  for (const GroupShape& shape : shapes) sum += shape.count;
  return sum;
}

GridMeasure MeasureBoxes(std::span<const Aabb> boxes, const ShapeClasses& classes,
                         StopRequest* stop) {
  GridMeasure measure;
  ForEachBlock(stop, 0, boxes.size(), [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(Measure)(boxes.subspan(begin, end - begin), classes, measure);
  });
  return measure;
}

}  // namespace sweepstake

#endif  // HWY_ONCE
