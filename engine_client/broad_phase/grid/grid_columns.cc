#include "engine_client/broad_phase/grid/grid_columns.h"

#include <algorithm>
#include <limits>

#include "hwy/cache_control.h"

namespace sweepstake {
namespace {

// Boxes ahead of the one being gathered: enough to hide the memory behind the last cache.
constexpr size_t kAhead = 24;

// Behind the last slot, for kernels that read a register past it.
constexpr size_t Padded(size_t count) {
  return (count + 2 * SoaBoxes::kPadding - 1) / SoaBoxes::kPadding * SoaBoxes::kPadding;
}

}  // namespace

void GridColumns::Resize(size_t count) {
  count_ = count;
  stride_ = Padded(count);
  floats_.EnsureDiscarding(6 * stride_);
  ids_.EnsureDiscarding(stride_);
  for (size_t column = 0; column < 6; ++column) {
    float* const floats = floats_.data() + column * stride_;
    std::fill(floats + count, floats + stride_, std::numeric_limits<float>::quiet_NaN());
  }
  std::fill(ids_.data() + count, ids_.data() + stride_, 0U);
}

void GridColumns::Gather(std::span<const Aabb> boxes, size_t begin, size_t end) {
  float* const columns[6] = {floats_.data(),
                             floats_.data() + stride_,
                             floats_.data() + 2 * stride_,
                             floats_.data() + 3 * stride_,
                             floats_.data() + 4 * stride_,
                             floats_.data() + 5 * stride_};
  const uint32_t* const ids = ids_.data();
  for (size_t k = begin; k < end; ++k) {
    hwy::Prefetch(&boxes[ids[std::min(k + kAhead, end - 1)]]);
    const Aabb& box = boxes[ids[k]];
    for (size_t axis = 0; axis < 3; ++axis) {
      columns[axis][k] = box.min[axis];
      columns[axis + 3][k] = box.max[axis];
    }
  }
}

void GridColumns::Blind(size_t slot) {
  for (size_t column = 0; column < 6; ++column) {
    floats_[column * stride_ + slot] = std::numeric_limits<float>::quiet_NaN();
  }
}

BoxLanes GridColumns::lanes() const {
  BoxLanes lanes{};
  for (size_t axis = 0; axis < 3; ++axis) {
    lanes.min[axis] = floats_.data() + axis * stride_;
    lanes.max[axis] = floats_.data() + (axis + 3) * stride_;
  }
  lanes.id = ids_.data();
  lanes.count = count_;
  return lanes;
}

}  // namespace sweepstake
