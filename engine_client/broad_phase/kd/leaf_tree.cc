#include "engine_client/broad_phase/kd/leaf_tree.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/kd/leaf_pairs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/leaf_tree.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/kd/leaf_bounds-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The nodes of a level, from what the level below holds.
void BoundGroups(const float* const* min, const float* const* max, const LeafTree::Level& level) {
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t node = 0; node < level.count; ++node) {
      level.min[axis][node] = LeastOf16(min[axis] + node * LeafTree::kWidth);
      level.max[axis][node] = GreatestOf16(max[axis] + node * LeafTree::kWidth);
    }
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(BoundGroups);

namespace {

constexpr size_t Groups(size_t count) { return (count + LeafTree::kWidth - 1) / LeafTree::kWidth; }

// Whole registers behind the last node, as behind the last box.
constexpr size_t PaddedColumn(size_t count) {
  return (count + 2 * SoaBoxes::kPadding - 1) / SoaBoxes::kPadding * SoaBoxes::kPadding;
}

}  // namespace

void LeafTree::LayOut(size_t box_count) {
  size_t floats = 0;
  level_count_ = 0;
  for (size_t count = Groups(box_count); count > 0; count = count == 1 ? 0 : Groups(count)) {
    levels_[level_count_++].count = count;
    floats += 6 * PaddedColumn(count);
    if (count <= kWidth) break;
  }
  bounds_.EnsureDiscarding(floats);
  float* column = bounds_.data();
  for (size_t index = 0; index < level_count_; ++index) {
    Level& level = levels_[index];
    const size_t stride = PaddedColumn(level.count);
    for (size_t axis = 0; axis < 3; ++axis, column += 2 * stride) {
      level.min[axis] = column;
      level.max[axis] = column + stride;
      std::fill(column + level.count, column + stride, std::numeric_limits<float>::infinity());
      std::fill(column + stride + level.count, column + 2 * stride,
                -std::numeric_limits<float>::infinity());
    }
  }
}

void LeafTree::Refit(const BoxLanes& lanes) {
  LayOut(lanes.count);
  if (level_count_ == 0) return;
  HWY_DYNAMIC_DISPATCH(BoundGroups)(lanes.min, lanes.max, levels_[0]);
  RefitNodes();
}

void LeafTree::RefitNodes() {
  for (size_t index = 1; index < level_count_; ++index) {
    const Level& below = levels_[index - 1];
    HWY_DYNAMIC_DISPATCH(BoundGroups)
    (below.min, below.max, levels_[index]);
  }
}

uint64_t LeafTree::FindPairs(const LeafBlock* leaves, size_t begin, size_t end,
                             PairBuffer& out) const {
  if (begin == end) return 0;
  return FindLeafPairs(leaves, levels_.data(), level_count_, begin, end, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
