#include "engine_client/broad_phase/kd/leaf_tree.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/leaf_tree.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "engine_client/broad_phase/common/valid_box-inl.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE void ReplaceInvalid(LeafBlock& leaf) {
  const Lanes16 d;
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  for (size_t at = 0; at < LeafBlock::kWidth; at += hn::Lanes(d)) {
    const auto valid = hn::And(hn::And(IsValidOnAxis(d, leaf.min[0] + at, leaf.max[0] + at),
                                       IsValidOnAxis(d, leaf.min[1] + at, leaf.max[1] + at)),
                               IsValidOnAxis(d, leaf.min[2] + at, leaf.max[2] + at));
    if (HWY_LIKELY(hn::AllTrue(d, valid))) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      float* const min = leaf.min[axis] + at;
      float* const max = leaf.max[axis] + at;
      hn::StoreU(hn::IfThenElse(valid, hn::LoadU(d, min), infinity), d, min);
      hn::StoreU(hn::IfThenElse(valid, hn::LoadU(d, max), hn::Neg(infinity)), d, max);
    }
  }
}

// Replaces invalid boxes by sentinels and computes the bounds of the leaves [begin, end). Column k
// of the bounds begins at columns + k * stride, in the order min x, max x, min y and so on.
void FinishLeaves(LeafBlock* leaves, size_t begin, size_t end, float* columns, size_t stride) {
  for (size_t leaf = begin; leaf < end; ++leaf) {
    ReplaceInvalid(leaves[leaf]);
    for (size_t axis = 0; axis < 3; ++axis) {
      columns[2 * axis * stride + leaf] = MinOf16(leaves[leaf].min[axis]);
      columns[(2 * axis + 1) * stride + leaf] = MaxOf16(leaves[leaf].max[axis]);
    }
  }
}

void BoundNodes(const BoxLanes& below, size_t begin, size_t end, float* columns, size_t stride) {
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t node = begin; node < end; ++node) {
      columns[2 * axis * stride + node] = MinOf16(below.min[axis] + node * LeafTree::kWidth);
      columns[(2 * axis + 1) * stride + node] = MaxOf16(below.max[axis] + node * LeafTree::kWidth);
    }
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(FinishLeaves);
HWY_EXPORT(BoundNodes);

namespace {

// The number of leaves that are filled before their bounds are computed. A vector load right after
// single-float stores would wait until they finish.
constexpr size_t kLeavesPerBatch = 8;
// The number of slots by which prefetching is ahead of reading.
constexpr size_t kPrefetchDistance = 32;
// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinLeavesPerPart = 128;

constexpr size_t GroupsOf16(size_t count) {
  return (count + LeafTree::kWidth - 1) / LeafTree::kWidth;
}

// Returns the length of a column with its padding, since whole registers may be read behind the
// last node.
constexpr size_t PaddedColumn(size_t count) {
  return (count + 2 * SoaBoxes::kPadding - 1) / SoaBoxes::kPadding * SoaBoxes::kPadding;
}

void GatherLeaf(std::span<const Aabb> boxes, std::span<const uint32_t> order, size_t first_slot,
                LeafBlock& leaf) {
  const auto entry = [&](size_t slot) { return slot < order.size() ? order[slot] : ~0U; };
  for (size_t lane = 0; lane < LeafBlock::kWidth; ++lane) {
    const uint32_t later = entry(first_slot + lane + kPrefetchDistance);
    if (later < boxes.size()) hwy::Prefetch(&boxes[later]);
    const uint32_t id = entry(first_slot + lane);
    const Aabb& box = id < boxes.size() ? boxes[id] : kInvalidAabb;
    for (size_t axis = 0; axis < 3; ++axis) {
      leaf.min[axis][lane] = box.min[axis];
      leaf.max[axis][lane] = box.max[axis];
    }
    leaf.id[lane] = id;
  }
}

}  // namespace

void LeafTree::Reserve(size_t slot_count, size_t capacity) {
  view_.top = 0;
  leaf_count_ = 0;
  leaves_.EnsureDiscarding(GroupsOf16(capacity));
  LayOut(slot_count, capacity);
}

// Divides `bounds_` into the columns of all levels and writes the sentinels behind each column.
void LeafTree::LayOut(size_t slot_count, size_t capacity) {
  capacity_ = capacity;
  level_count_ = 0;
  size_t floats = 0;
  for (size_t count = GroupsOf16(capacity); count > 0; count = GroupsOf16(count)) {
    stride_[++level_count_] = PaddedColumn(count);
    floats += 6 * PaddedColumn(count);
    if (count <= kWidth) break;
  }
  bounds_.EnsureDiscarding(floats);
  SetCounts(slot_count);
  float* column = bounds_.data();
  for (size_t level = 1; level <= level_count_; ++level) {
    BoxLanes& lanes = view_.levels[level];
    const size_t stride = stride_[level];
    first_column_[level] = column;
    for (size_t axis = 0; axis < 3; ++axis, column += 2 * stride) {
      lanes.min[axis] = column;
      lanes.max[axis] = column + stride;
      std::fill(column + lanes.count, column + stride, kInfinity);
      std::fill(column + stride + lanes.count, column + 2 * stride, -kInfinity);
    }
  }
}

void LeafTree::SetCounts(size_t slot_count) {
  view_.top = 0;
  size_t count = slot_count;
  for (size_t level = 1; level <= level_count_; ++level) {
    count = GroupsOf16(count);
    view_.levels[level].count = count;
    if (view_.top == 0 && count > 0 && count <= kWidth) view_.top = level;
  }
}

void LeafTree::Refit(std::span<const Aabb> boxes, std::span<const uint32_t> order,
                     Executor* executor, StopRequest* stop, size_t spare_slots) {
  Reserve(order.size(), order.size() + spare_slots);
  if (order.empty()) return;
  leaf_count_ = GroupsOf16(order.size());
  view_.leaves = leaves_.data();
  view_.levels[0] = LanesOf(leaves_[0]);
  view_.levels[0].count = order.size();
  const size_t part_count = PartCount(executor, leaf_count_, kMinLeavesPerPart);
  RunParts(executor, part_count, [&](size_t part) {
    const PartRange range = RangeOfPart(leaf_count_, part, part_count, 1);
    const auto gather = [&](size_t from, size_t to) { GatherLeaves(boxes, order, from, to); };
    ForEachBlock(stop, range.begin, range.end, gather, kBoxesPerQuestion / kWidth);
  });
  if (IsStopped(stop)) return;
  for (size_t level = 2; level <= level_count_; ++level) {
    BoundFrom(level, 0, view_.levels[level].count);
  }
}

void LeafTree::RefitBlocks(std::span<const Aabb> boxes, std::span<const uint32_t> order,
                           std::span<const uint32_t> blocks) {
  if (order.size() > capacity_) Grow(order.size());
  SetCounts(order.size());
  leaf_count_ = GroupsOf16(order.size());
  view_.levels[0].count = order.size();
  for (const uint32_t block : blocks) {
    const size_t first = size_t{block} * kWidth;
    GatherLeaves(boxes, order, first, std::min(first + kWidth, leaf_count_));
  }
  for (size_t level = 2; level <= level_count_; ++level) {
    size_t next = 0;
    for (const uint32_t block : blocks) {
      const size_t node = size_t{block} >> kWidthBits * (level - 2);
      if (node >= next) BoundFrom(level, node, node + 1);
      next = node + 1;
    }
  }
}

// Moves the leaves to a larger block of memory and computes all bounds again.
void LeafTree::Grow(size_t slot_count) {
  leaves_.EnsureKeeping(GroupsOf16(slot_count), leaf_count_);
  LayOut(leaf_count_ * kWidth, leaves_.capacity() * kWidth);
  view_.leaves = leaves_.data();
  view_.levels[0] = LanesOf(leaves_[0]);
  HWY_DYNAMIC_DISPATCH(FinishLeaves)
  (leaves_.data(), 0, leaf_count_, first_column_[1], stride_[1]);
  for (size_t level = 2; level <= level_count_; ++level) {
    BoundFrom(level, 0, view_.levels[level].count);
  }
}

// Computes the bounds of the nodes [begin, end) of a level from the nodes below them.
void LeafTree::BoundFrom(size_t level, size_t begin, size_t end) {
  HWY_DYNAMIC_DISPATCH(BoundNodes)
  (view_.levels[level - 1], begin, end, first_column_[level], stride_[level]);
}

void LeafTree::GatherLeaves(std::span<const Aabb> boxes, std::span<const uint32_t> order,
                            size_t begin, size_t end) {
  for (size_t first = begin; first < end; first += kLeavesPerBatch) {
    const size_t last = std::min(first + kLeavesPerBatch, end);
    for (size_t leaf = first; leaf < last; ++leaf) {
      GatherLeaf(boxes, order, leaf * kWidth, leaves_[leaf]);
    }
    HWY_DYNAMIC_DISPATCH(FinishLeaves)
    (leaves_.data(), first, last, first_column_[1], stride_[1]);
  }
}

}  // namespace sweepstake

#endif  // HWY_ONCE
