#include "engine_client/broad_phase/common/soa_boxes.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/common/soa_boxes.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/valid_box-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Replaces invalid boxes by sentinels. They are rare, so that only registers with an invalid box
// are written back.
void ReplaceInvalidBoxes(float* const* columns, size_t padded_count) {
  const HWY_FULL(float) d;
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < padded_count; i += hn::Lanes(d)) {
    const auto valid = hn::And(hn::And(IsValidOnAxis(d, columns[0] + i, columns[3] + i),
                                       IsValidOnAxis(d, columns[1] + i, columns[4] + i)),
                               IsValidOnAxis(d, columns[2] + i, columns[5] + i));
    if (hn::AllTrue(d, valid)) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      float* const min = columns[axis] + i;
      float* const max = columns[axis + 3] + i;
      hn::Store(hn::IfThenElse(valid, hn::Load(d, min), infinity), d, min);
      hn::Store(hn::IfThenElse(valid, hn::Load(d, max), hn::Neg(infinity)), d, max);
    }
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(ReplaceInvalidBoxes);

void SoaBoxes::Gather(std::span<const Aabb> boxes) {
  Resize(boxes.size());
  for (size_t axis = 0; axis < 3; ++axis) {
    float* const min = Column(axis);
    float* const max = Column(axis + 3);
    for (size_t k = 0; k < boxes.size(); ++k) {
      min[k] = boxes[k].min[axis];
      max[k] = boxes[k].max[axis];
    }
  }
  for (size_t k = 0; k < boxes.size(); ++k) ids_[k] = static_cast<uint32_t>(k);
  Finish();
}

void SoaBoxes::Gather(std::span<const Aabb> boxes, std::span<const uint32_t> order) {
  Resize(order.size());
  float* const columns[6] = {Column(0), Column(1), Column(2), Column(3), Column(4), Column(5)};
  for (size_t k = 0; k < order.size(); ++k) {
    const Aabb& box = boxes[order[k]];
    for (size_t axis = 0; axis < 3; ++axis) {
      columns[axis][k] = box.min[axis];
      columns[axis + 3][k] = box.max[axis];
    }
  }
  std::copy(order.begin(), order.end(), ids_.data());
  Finish();
}

BoxLanes SoaBoxes::Lanes(int first_axis) const {
  BoxLanes lanes{};
  for (size_t k = 0; k < 3; ++k) {
    const size_t axis = (static_cast<size_t>(first_axis) + k) % 3;
    lanes.min[k] = floats_.data() + axis * stride_;
    lanes.max[k] = floats_.data() + (axis + 3) * stride_;
  }
  lanes.id = ids_.data();
  lanes.count = count_;
  return lanes;
}

void SoaBoxes::Resize(size_t count) {
  count_ = count;
  // A multiple of the padding keeps every column aligned to a register.
  stride_ = (count + 2 * kPadding - 1) / kPadding * kPadding;
  floats_.EnsureDiscarding(6 * stride_);
  ids_.EnsureDiscarding(stride_);
}

// Replaces invalid boxes and fills the padding behind the last box.
void SoaBoxes::Finish() {
  constexpr float kAboveAll = std::numeric_limits<float>::infinity();
  for (size_t axis = 0; axis < 3; ++axis) {
    std::fill(Column(axis) + count_, Column(axis) + stride_, kAboveAll);
    std::fill(Column(axis + 3) + count_, Column(axis + 3) + stride_, -kAboveAll);
  }
  std::fill(ids_.data() + count_, ids_.data() + stride_, 0U);
  float* const columns[6] = {Column(0), Column(1), Column(2), Column(3), Column(4), Column(5)};
  const size_t used = (count_ + kPadding - 1) / kPadding * kPadding;
  HWY_DYNAMIC_DISPATCH(ReplaceInvalidBoxes)(columns, used);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
