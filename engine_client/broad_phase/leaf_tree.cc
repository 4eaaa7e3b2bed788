#include "engine_client/broad_phase/leaf_tree.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/leaf_tree.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

using Lanes16 = hn::CappedTag<float, LeafTree::kWidth>;

// The 16 values from `values` on, reduced to one.
HWY_INLINE float LeastOf16(const float* values) {
  const Lanes16 d;
  auto least = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < LeafTree::kWidth; at += hn::Lanes(d)) {
    least = hn::Min(least, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

HWY_INLINE float GreatestOf16(const float* values) {
  const Lanes16 d;
  auto greatest = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < LeafTree::kWidth; at += hn::Lanes(d)) {
    greatest = hn::Max(greatest, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MaxOfLanes(d, greatest));
}

void BoundGroups(const float* const* min, const float* const* max, const LeafTree::Level& level) {
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t node = 0; node < level.count; ++node) {
      level.min[axis][node] = LeastOf16(min[axis] + node * LeafTree::kWidth);
      level.max[axis][node] = GreatestOf16(max[axis] + node * LeafTree::kWidth);
    }
  }
}

// Which of the 16 entries from `base` on overlap `bounds`: their indices, if at least `from`, go to
// `found`. Returns how many did; writes up to a register more.
HWY_INLINE size_t CollectOverlapping(const Aabb& bounds, const BoxLanes& lanes, size_t base,
                                     uint32_t from, uint32_t* found) {
  const Lanes16 d;
  const hn::RebindToUnsigned<decltype(d)> du;
  size_t count = 0;
  for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
    const auto index = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<uint32_t>(at)));
    const auto earlier = hn::Lt(index, hn::Set(du, from));
    const auto hits = hn::AndNot(earlier, hn::RebindMask(du, Hits(d, bounds, lanes, at)));
    hn::StoreU(hn::Compress(index, hits), du, found + count);
    count += hn::CountTrue(du, hits);
  }
  return count;
}

HWY_INLINE BoxLanes AsLanes(const LeafTree::Level& level) {
  BoxLanes lanes{};
  for (size_t axis = 0; axis < 3; ++axis) {
    lanes.min[axis] = level.min[axis];
    lanes.max[axis] = level.max[axis];
  }
  lanes.count = level.count;
  return lanes;
}

struct Found {
  uint32_t* entries;  // one of the queues
  size_t count;
  uint64_t checks;
};

// From the top down to the boxes in later leaves that overlap the bounds of leaf `leaf`.
HWY_INLINE Found Descend(const BoxLanes& boxes, const BoxLanes* levels, size_t level_count,
                         uint32_t leaf, const Aabb& bounds, uint32_t* const* queues) {
  size_t current = 0;
  size_t count = 1;
  uint64_t checks = 0;
  queues[0][0] = 0;
  for (size_t level = level_count + 1; level-- > 0;) {
    // Level 0 of this loop are the boxes: those of later leaves; above it, nodes that hold later
    // leaves.
    const BoxLanes& lanes = level == 0 ? boxes : levels[level - 1];
    const uint32_t from = level == 0 ? 0
                          : level == 1
                              ? leaf + 1
                              : leaf >> (LeafTree::kWidthBits * static_cast<uint32_t>(level - 1));
    const uint32_t* const parents = queues[current];
    uint32_t* const found = queues[1 - current];
    size_t found_count = 0;
    for (size_t k = 0; k < count; ++k) {
      found_count += CollectOverlapping(bounds, lanes, size_t{parents[k]} * LeafTree::kWidth, from,
                                        found + found_count);
    }
    checks += count * LeafTree::kWidth;
    current = 1 - current;
    count = found_count;
  }
  return {queues[current], count, checks};
}

// One axis of boxes kept in registers against one box.
template <class D>
HWY_INLINE hn::Mask<D> AxisHitsOfHeld(D d, hn::Vec<D> min, hn::Vec<D> max, const BoxLanes& lanes,
                                      size_t axis, size_t slot) {
  return hn::And(hn::Le(min, hn::Set(d, lanes.max[axis][slot])),
                 hn::Ge(max, hn::Set(d, lanes.min[axis][slot])));
}

// The leaf's boxes, as many of them at a time as a register holds, against each other and against
// `found`.
HWY_INLINE uint64_t TestLeaf(const BoxLanes& lanes, size_t first_slot, const Found& found,
                             PairCursor& cursor) {
  const Lanes16 d;
  const size_t step = hn::Lanes(d);
  for (size_t part = 0; part < LeafTree::kWidth; part += step) {
    const size_t at = first_slot + part;
    const auto min0 = hn::LoadU(d, lanes.min[0] + at);
    const auto min1 = hn::LoadU(d, lanes.min[1] + at);
    const auto min2 = hn::LoadU(d, lanes.min[2] + at);
    const auto max0 = hn::LoadU(d, lanes.max[0] + at);
    const auto max1 = hn::LoadU(d, lanes.max[1] + at);
    const auto max2 = hn::LoadU(d, lanes.max[2] + at);
    const auto test = [&](size_t slot, hn::Mask<Lanes16> asked) HWY_ATTR {
      const auto hits = hn::And(hn::And(AxisHitsOfHeld(d, min0, max0, lanes, 0, slot),
                                        AxisHitsOfHeld(d, min1, max1, lanes, 1, slot)),
                                hn::And(AxisHitsOfHeld(d, min2, max2, lanes, 2, slot), asked));
      cursor.Advance(StoreHits(d, hits, lanes.id[slot], lanes.id + at, cursor.Room(step)));
    };
    // Slot k of the leaf meets the lanes behind it.
    for (size_t k = 0; k < part + step; ++k) {
      test(first_slot + k, SlotsFrom(d, k < part ? 0 : k - part + 1, 0));
    }
    const auto all = hn::FirstN(d, step);
    for (size_t k = 0; k < found.count; ++k) test(found.entries[k], all);
  }
  return (LeafTree::kWidth + found.count) * LeafTree::kWidth;
}

uint64_t LeafPairs(const BoxLanes& boxes, const LeafTree::Level* levels, size_t level_count,
                   uint32_t* const* queues, PairBuffer& out) {
  BoxLanes level_lanes[LeafTree::kMaxLevels];
  for (size_t level = 0; level < level_count; ++level) level_lanes[level] = AsLanes(levels[level]);
  const BoxLanes local = boxes;
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (uint32_t leaf = 0; leaf < level_lanes[0].count; ++leaf) {
    const Aabb bounds = BoxAt(level_lanes[0], leaf);
    const Found found = Descend(local, level_lanes, level_count, leaf, bounds, queues);
    checks += found.checks;
    checks += TestLeaf(local, size_t{leaf} * LeafTree::kWidth, found, cursor);
  }
  cursor.Flush();
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(BoundGroups);
HWY_EXPORT(LeafPairs);

namespace {

constexpr size_t Groups(size_t count) { return (count + LeafTree::kWidth - 1) / LeafTree::kWidth; }

// Whole registers behind the last node, as behind the last box.
constexpr size_t PaddedColumn(size_t count) {
  return (count + 2 * SoaBoxes::kPadding - 1) / SoaBoxes::kPadding * SoaBoxes::kPadding;
}

}  // namespace

void LeafTree::LayOutLevels(size_t box_count) {
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
  LayOutLevels(lanes.count);
  const float* const* min = lanes.min;
  const float* const* max = lanes.max;
  for (size_t index = 0; index < level_count_; ++index) {
    HWY_DYNAMIC_DISPATCH(BoundGroups)(min, max, levels_[index]);
    min = levels_[index].min;
    max = levels_[index].max;
  }
}

uint64_t LeafTree::FindPairs(const BoxLanes& lanes, PairBuffer& out) {
  if (level_count_ == 0) return 0;
  // At most every slot of every leaf, and a register over.
  for (auto& queue : queues_) queue.EnsureDiscarding(lanes.count + 2 * kWidth);
  uint32_t* const queues[2] = {queues_[0].data(), queues_[1].data()};
  return HWY_DYNAMIC_DISPATCH(LeafPairs)(lanes, levels_.data(), level_count_, queues, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
