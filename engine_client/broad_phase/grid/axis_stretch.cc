#include "engine_client/broad_phase/grid/axis_stretch.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "engine_client/broad_phase/common/coordinate_range.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid/axis_stretch.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Stretches halved coordinates on one axis.
template <class D>
HWY_INLINE hn::Vec<D> StretchCoordinates(D d, const AxisStretch::Axis& axis, hn::Vec<D> halved) {
  const auto zero = hn::Zero(d);
  auto sum = zero;
  for (size_t k = 0; k < axis.count; ++k) {
    const auto from_begin = hn::Sub(halved, hn::Set(d, axis.begin[k]));
    const auto risen = hn::Mul(from_begin, hn::Set(d, axis.scale[k]));
    sum = hn::Add(sum, hn::Min(hn::Max(risen, zero), hn::Set(d, axis.rise[k])));
  }
  return sum;
}

void Stretch(std::span<const Aabb> boxes, const std::array<AxisStretch::Axis, 3>& axes, Aabb* out) {
  const HWY_FULL(float) d;
  const auto nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  HWY_ALIGN float columns[6][HWY_MAX_BYTES / sizeof(float)];
  const auto stretch = [&](size_t at, auto valid, auto x, auto y, auto z, auto max_x, auto max_y,
                           auto max_z) HWY_ATTR {
    const auto store = [&](size_t column, auto halved) HWY_ATTR {
      const auto stretched = StretchCoordinates(d, axes[column % 3], halved);
      hn::Store(hn::IfThenElse(valid, stretched, nan), d, columns[column]);
    };
    store(0, x);
    store(1, y);
    store(2, z);
    store(3, max_x);
    store(4, max_y);
    store(5, max_z);
    const size_t end = std::min(hn::Lanes(d), boxes.size() - at);
    for (size_t k = 0; k < end; ++k) {
      out[at + k] = {{columns[0][k], columns[1][k], columns[2][k]},
                     {columns[3][k], columns[4][k], columns[5][k]}};
    }
  };
  ForEachHalved(d, boxes, stretch);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Stretch);

namespace {

// The number of ranks by which a straight line may miss a sampled coordinate.
constexpr float kMaxMissedRanks = AxisStretch::kSample / 100.0F;

}  // namespace

void AxisStretch::Fit(std::span<const Aabb> boxes) {
  const size_t draws = std::min(boxes.size(), kSample);
  for (size_t axis = 0; axis < 3; ++axis) {
    std::array<float, kSample> sample;
    size_t count = 0;
    for (size_t k = 0; k < draws; ++k) {
      const Aabb& box = boxes[draws == boxes.size() ? k : DrawIndex(k, boxes.size())];
      if (IsValid(box)) sample[count++] = 0.5F * box.min[axis];
    }
    if (count == 0) sample[count++] = 0;
    std::sort(sample.begin(), sample.begin() + count);
    axes_[axis] = Axis::Fit({sample.data(), count}, kMaxMissedRanks);
  }
}

void AxisStretch::SetWeights(const std::array<float, 3>& weights) {
  for (size_t axis = 0; axis < 3; ++axis) {
    for (float& scale : axes_[axis].scale) scale *= weights[axis];
    for (float& rise : axes_[axis].rise) rise *= weights[axis];
  }
}

void AxisStretch::Apply(std::span<const Aabb> boxes, Aabb* out) const {
  HWY_DYNAMIC_DISPATCH(Stretch)(boxes, axes_, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
