#include "engine_client/broad_phase/kd/leaf_boxes.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/leaf_boxes.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/common/takes_part-inl.h"
#include "engine_client/broad_phase/kd/leaf_bounds-inl.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE void ReplaceAbsent(LeafBlock& block) {
  const Lanes16 d;
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  for (size_t at = 0; at < LeafTree::kWidth; at += hn::Lanes(d)) {
    const auto present = hn::And(hn::And(AxisTakesPart(d, block.min[0] + at, block.max[0] + at),
                                         AxisTakesPart(d, block.min[1] + at, block.max[1] + at)),
                                 AxisTakesPart(d, block.min[2] + at, block.max[2] + at));
    if (HWY_LIKELY(hn::AllTrue(d, present))) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      float* const min = block.min[axis] + at;
      float* const max = block.max[axis] + at;
      hn::StoreU(hn::IfThenElse(present, hn::LoadU(d, min), infinity), d, min);
      hn::StoreU(hn::IfThenElse(present, hn::LoadU(d, max), hn::Neg(infinity)), d, max);
    }
  }
}

void FinishLeaves(LeafBlock* blocks, size_t begin, size_t end, const LeafTree::Level& leaves) {
  for (size_t leaf = begin; leaf < end; ++leaf) {
    ReplaceAbsent(blocks[leaf]);
    for (size_t axis = 0; axis < 3; ++axis) {
      leaves.min[axis][leaf] = LeastOf16(blocks[leaf].min[axis]);
      leaves.max[axis][leaf] = GreatestOf16(blocks[leaf].max[axis]);
    }
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(FinishLeaves);

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Aabb kAbsent = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
// Leaves whose bounds are taken together: a register is not loaded from floats just stored.
constexpr size_t kBatch = 8;
// Boxes whose order is known far enough ahead to fetch them.
constexpr size_t kAhead = 32;

void GatherLeaf(std::span<const Aabb> boxes, std::span<const uint32_t> order, size_t first_slot,
                LeafBlock& block) {
  const auto entry = [&](size_t slot) { return slot < order.size() ? order[slot] : ~0U; };
  for (size_t lane = 0; lane < LeafTree::kWidth; ++lane) {
    const uint32_t later = entry(first_slot + lane + kAhead);
    if (later < boxes.size()) hwy::Prefetch(&boxes[later]);
    const uint32_t id = entry(first_slot + lane);
    const Aabb& box = id < boxes.size() ? boxes[id] : kAbsent;
    for (size_t axis = 0; axis < 3; ++axis) {
      block.min[axis][lane] = box.min[axis];
      block.max[axis][lane] = box.max[axis];
    }
    block.id[lane] = id;
  }
}

}  // namespace

void LeafBoxes::Resize(size_t slot_count) {
  leaf_count_ = (slot_count + LeafTree::kWidth - 1) / LeafTree::kWidth;
  blocks_.EnsureDiscarding(leaf_count_);
}

void LeafBoxes::GatherLeaves(std::span<const Aabb> boxes, std::span<const uint32_t> order,
                             size_t begin, size_t end, const LeafTree::Level& leaves) {
  for (size_t first = begin; first < end; first += kBatch) {
    const size_t last = std::min(first + kBatch, end);
    for (size_t leaf = first; leaf < last; ++leaf) {
      GatherLeaf(boxes, order, leaf * LeafTree::kWidth, blocks_[leaf]);
    }
    HWY_DYNAMIC_DISPATCH(FinishLeaves)(blocks_.data(), first, last, leaves);
  }
}

BoxGroups LeafBoxes::Groups() const {
  const LeafBlock& first = blocks_[0];
  return {{first.min[0], first.min[1], first.min[2]},
          {first.max[0], first.max[1], first.max[2]},
          first.id,
          sizeof(LeafBlock) / sizeof(float),
          leaf_count_};
}

}  // namespace sweepstake

#endif  // HWY_ONCE
