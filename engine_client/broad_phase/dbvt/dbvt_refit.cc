#include "engine_client/broad_phase/dbvt/dbvt_refit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/dbvt/dbvt_refit.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "hwy/cache_control.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes16 = hn::CappedTag<float, DbvtNode::kWidth>;

HWY_INLINE float LeastLane(const float* values) {
  const Lanes16 d;
  auto least = hn::Load(d, values);
  for (size_t at = hn::Lanes(d); at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    least = hn::Min(least, hn::Load(d, values + at));
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

HWY_INLINE float GreatestLane(const float* values) {
  const Lanes16 d;
  auto greatest = hn::Load(d, values);
  for (size_t at = hn::Lanes(d); at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    greatest = hn::Max(greatest, hn::Load(d, values + at));
  }
  return hn::GetLane(hn::MaxOfLanes(d, greatest));
}

Aabb BoundsOf(const DbvtNode& node) {
  Aabb bounds;
  for (size_t axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = LeastLane(node.min[axis]);
    bounds.max[axis] = GreatestLane(node.max[axis]);
  }
  return bounds;
}

// The sum of a box's sides, lane by lane.
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
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Gt(sides, reach), bits);
    stretched |= (bits[0] | uint32_t{bits[1]} << 8) << at;
    hn::Store(hn::Min(reach, hn::Mul(sides, hn::Set(d, DbvtTree::kMargin))), d, node.reach + at);
  }
  return static_cast<uint16_t>(stretched);
}

HWY_INLINE bool AllTakePart(const DbvtNode& leaf, const Aabb& bounds, size_t count) {
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

// Largest step on an axis from where the lane has the box.
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

// The processor does not foresee the order of a leaf's objects.
HWY_INLINE void FetchAhead(const DbvtNode& leaf, size_t count, const Aabb* boxes) {
  for (size_t lane = 0; lane < count; ++lane) {
    const Aabb* const box = boxes + leaf.child[lane];
    hwy::Prefetch(box->min);
    hwy::Prefetch(box->max + 2);  // every third box ends in another cache line
  }
}

DbvtGroupNote Refit(DbvtNode* HWY_RESTRICT nodes, const DbvtLink* links, uint32_t group_node,
                    const Aabb* boxes, float step) {
  DbvtNode& group = nodes[group_node];
  const size_t leaf_count = links[group_node].count;
  DbvtGroupNote note{};
  for (size_t lane = 0; lane < leaf_count; ++lane) {
    DbvtNode& leaf = nodes[group.child[lane]];
    if (lane + 2 < leaf_count) {
      const uint32_t ahead = group.child[lane + 2];
      FetchAhead(nodes[ahead], links[ahead].count, boxes);
    }
    const float motion = MotionFrom(leaf, 0, boxes[leaf.child[0]]);
    note.restless += motion <= step ? 0 : 1;
    note.motion += std::min(motion, step);
    TakeBoxes(leaf, links[group.child[lane]].count, boxes);
  }
  // Apart from the loop above: registers that read what was just written by single floats wait for
  // it.
  for (size_t lane = 0; lane < leaf_count; ++lane) {
    const DbvtNode& leaf = nodes[group.child[lane]];
    const Aabb bounds = BoundsOf(leaf);
    for (size_t axis = 0; axis < 3; ++axis) {
      group.min[axis][lane] = bounds.min[axis];
      group.max[axis][lane] = bounds.max[axis];
    }
    if (!AllTakePart(leaf, bounds, links[group.child[lane]].count)) {
      note.broken = static_cast<uint16_t>(note.broken | 1U << lane);
    }
  }
  note.stretched = Stretched(group);
  return note;
}

// The lane that grows least by the box; of lanes that grow alike the smaller one.
HWY_INLINE uint32_t BestLane(const DbvtNode& node, const Aabb& box) {
  const Lanes16 d;
  float least = std::numeric_limits<float>::infinity();
  size_t best = 0;
  for (size_t at = 0; at < DbvtNode::kWidth; at += hn::Lanes(d)) {
    auto joined = hn::Zero(d);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto low = hn::Min(hn::Load(d, node.min[axis] + at), hn::Set(d, box.min[axis]));
      const auto high = hn::Max(hn::Load(d, node.max[axis] + at), hn::Set(d, box.max[axis]));
      joined = hn::Add(joined, hn::Sub(high, low));
    }
    // Infinite for lanes without a child.
    const auto cost = hn::Sub(hn::Mul(joined, hn::Set(d, 1.0625F)), Sides(node, at));
    const float cost_here = hn::GetLane(hn::MinOfLanes(d, cost));
    if (!(cost_here < least)) continue;
    least = cost_here;
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
    at.reach[lane] = std::max(at.reach[lane], DbvtTree::kMargin * sides);
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
