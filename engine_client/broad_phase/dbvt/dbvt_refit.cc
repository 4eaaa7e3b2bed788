#include "engine_client/broad_phase/dbvt/dbvt_refit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/dbvt/dbvt_refit.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

Aabb BoundsOf(const DbvtNode& node) {
  Aabb bounds;
  for (size_t axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = MinOf16(node.min[axis]);
    bounds.max[axis] = MaxOf16(node.max[axis]);
  }
  return bounds;
}

// Returns the size (sum of sides) of each lane's box.
HWY_INLINE hn::Vec<Lanes16> Sides(const DbvtNode& node, size_t at) {
  const Lanes16 d;
  auto sides = hn::Sub(hn::Load(d, node.max[0] + at), hn::Load(d, node.min[0] + at));
  for (size_t axis = 1; axis < 3; ++axis) {
    sides =
        hn::Add(sides, hn::Sub(hn::Load(d, node.max[axis] + at), hn::Load(d, node.min[axis] + at)));
  }
  return sides;
}

uint16_t Stretched(DbvtNode& node) {
  const Lanes16 d;
  uint32_t stretched = 0;
  for (size_t at = 0; at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    const auto sides = Sides(node, at);
    const auto reach = hn::Load(d, node.reach + at);
    stretched |= BitsOfMask(d, hn::Gt(sides, reach)) << at;
    hn::Store(hn::Min(reach, hn::Mul(sides, hn::Set(d, DbvtTree::kReachFactor))), d,
              node.reach + at);
  }
  return static_cast<uint16_t>(stretched);
}

HWY_INLINE bool AllAreValid(const DbvtNode& leaf, const Aabb& bounds, size_t count) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  const Lanes16 d;
  size_t in_order = 0;
  for (size_t at = 0; at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    auto ordered = hn::Le(hn::Load(d, leaf.min[0] + at), hn::Load(d, leaf.max[0] + at));
    for (size_t axis = 1; axis < 3; ++axis) {
      ordered = hn::And(ordered,
                        hn::Le(hn::Load(d, leaf.min[axis] + at), hn::Load(d, leaf.max[axis] + at)));
    }
    in_order += hn::CountTrue(d, ordered);
  }
  bool finite = true;
  for (size_t axis = 0; axis < 3; ++axis) {
    finite &= bounds.min[axis] >= -kLargest && bounds.max[axis] <= kLargest;
  }
  return finite && in_order == count;
}

// Returns the largest distance on an axis by which the box has moved from the lane's box.
HWY_INLINE float MotionFrom(const DbvtNode& leaf, size_t lane, const Aabb& box) {
  float motion = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    motion = std::max(motion, std::abs(box.min[axis] - leaf.min[axis][lane]));
  }
  return motion;
}

HWY_INLINE void TakeBoxes(DbvtNode& leaf, size_t count, const Aabb* HWY_RESTRICT boxes) {
  for (size_t lane = 0; lane < count; ++lane) {
    const Aabb& box = boxes[leaf.child[lane]];
    for (size_t axis = 0; axis < 3; ++axis) {
      leaf.min[axis][lane] = box.min[axis];
      leaf.max[axis][lane] = box.max[axis];
    }
  }
}

// Prefetches the boxes of a leaf's objects. They are scattered in memory, so that the processor
// does not prefetch them itself.
HWY_INLINE void FetchAhead(const DbvtNode& leaf, size_t count, const Aabb* boxes) {
  for (size_t lane = 0; lane < count; ++lane) {
    const Aabb* const box = boxes + leaf.child[lane];
    hwy::Prefetch(box->min);
    hwy::Prefetch(box->max + 2);  // some boxes end in the next cache line
  }
}

DbvtGroupNote Refit(DbvtNode* HWY_RESTRICT nodes, const DbvtLink* links, uint32_t group_node,
                    const Aabb* boxes, float step) {
  DbvtNode& group = nodes[group_node];
  const size_t leaf_count = links[group_node].count;
  DbvtGroupNote note{};
  // First loop, leaf by leaf: samples the motion and copies the new boxes to the leaf.
  for (size_t lane = 0; lane < leaf_count; ++lane) {
    DbvtNode& leaf = nodes[group.child[lane]];
    if (lane + 2 < leaf_count) {
      const uint32_t ahead = group.child[lane + 2];
      FetchAhead(nodes[ahead], links[ahead].count, boxes);
    }
    const float motion = MotionFrom(leaf, 0, boxes[leaf.child[0]]);
    note.fast_count += motion <= step ? 0 : 1;
    note.motion += std::min(motion, step);
    TakeBoxes(leaf, links[group.child[lane]].count, boxes);
  }
  // Second loop: computes the bounds of the leaves. In the first loop, a vector load right after
  // stores of single floats would stall until the stores finish.
  for (size_t lane = 0; lane < leaf_count; ++lane) {
    const DbvtNode& leaf = nodes[group.child[lane]];
    const Aabb bounds = BoundsOf(leaf);
    for (size_t axis = 0; axis < 3; ++axis) {
      group.min[axis][lane] = bounds.min[axis];
      group.max[axis][lane] = bounds.max[axis];
    }
    if (!AllAreValid(leaf, bounds, links[group.child[lane]].count)) {
      note.invalid = static_cast<uint16_t>(note.invalid | 1U << lane);
    }
  }
  note.stretched = Stretched(group);
  return note;
}

// Returns the lane whose box grows least if it has to cover `box`. Among similar lanes it prefers a
// small box.
HWY_INLINE uint32_t BestLane(const DbvtNode& node, const Aabb& box) {
  const Lanes16 d;
  float min_cost = std::numeric_limits<float>::infinity();
  size_t best = 0;
  for (size_t at = 0; at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    auto joined = hn::Zero(d);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto low = hn::Min(hn::Load(d, node.min[axis] + at), hn::Set(d, box.min[axis]));
      const auto high = hn::Max(hn::Load(d, node.max[axis] + at), hn::Set(d, box.max[axis]));
      joined = hn::Add(joined, hn::Sub(high, low));
    }
    // The cost is the growth plus a sixteenth of the new size, so that small boxes are preferred.
    // It is infinite for lanes without a child.
    const auto cost = hn::Sub(hn::Mul(joined, hn::Set(d, 1.0625F)), Sides(node, at));
    const float cost_here = hn::GetLane(hn::MinOfLanes(d, cost));
    if (!(cost_here < min_cost)) continue;
    min_cost = cost_here;
    const intptr_t lane = hn::FindFirstTrue(d, hn::Eq(cost, hn::Set(d, cost_here)));
    best = at + static_cast<size_t>(std::max<intptr_t>(lane, 0));
  }
  return static_cast<uint32_t>(best);
}

uint32_t Descend(DbvtNode* HWY_RESTRICT nodes, const DbvtLink* links, uint32_t root, uint32_t level,
                 const Aabb& box) {
  uint32_t node = root;
  while (links[node].level > level) {
    DbvtNode& at = nodes[node];
    const uint32_t lane = BestLane(at, box);
    float sides = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      at.min[axis][lane] = std::min(at.min[axis][lane], box.min[axis]);
      at.max[axis][lane] = std::max(at.max[axis][lane], box.max[axis]);
      sides += at.max[axis][lane] - at.min[axis][lane];
    }
    at.reach[lane] = std::max(at.reach[lane], DbvtTree::kReachFactor * sides);
    node = at.child[lane];
  }
  return node;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(BoundsOf);
HWY_EXPORT(Stretched);
HWY_EXPORT(Refit);
HWY_EXPORT(Descend);

Aabb NodeBounds(const DbvtNode& node) { return HWY_DYNAMIC_DISPATCH(BoundsOf)(node); }

uint16_t StretchedLanes(DbvtNode& node) { return HWY_DYNAMIC_DISPATCH(Stretched)(node); }

DbvtGroupNote RefitGroup(DbvtNode* nodes, const DbvtLink* links, uint32_t group, const Aabb* boxes,
                         float step) {
  return HWY_DYNAMIC_DISPATCH(Refit)(nodes, links, group, boxes, step);
}

uint32_t DescendWidening(DbvtNode* nodes, const DbvtLink* links, uint32_t root, uint32_t level,
                         const Aabb& box) {
  return HWY_DYNAMIC_DISPATCH(Descend)(nodes, links, root, level, box);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
