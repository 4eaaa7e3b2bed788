#include "engine_client/broad_phase/dbvt_query.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/dbvt_query.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/pair_cursor.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

// No half registers here: the same tests, one coordinate at a time.
struct Sought {
  const float* min;
  const float* max;
};

HWY_INLINE Sought Seek(const DbvtNode& node) { return {node.min, node.max}; }

HWY_INLINE bool CoordinatesOverlap(const Sought& sought, const float* min, const float* max) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap &= min[axis] <= sought.max[axis];
    overlap &= max[axis] >= sought.min[axis];
  }
  return overlap;
}

HWY_INLINE bool NodeOverlaps(const Sought& sought, const DbvtNode& node) {
  return CoordinatesOverlap(sought, node.min, node.max);
}

HWY_INLINE bool PackedOverlap(const PackedBox& a, const PackedBox& b) {
  return CoordinatesOverlap({a.min, a.max}, b.min, b.max);
}

#else

using Half = hn::FixedTag<float, 4>;
using HalfVector = hn::Vec<Half>;

// The box that is sought, against nodes whose fourth lanes hold children.
struct Sought {
  HalfVector min;
  HalfVector max;
};

HWY_INLINE Sought Seek(const DbvtNode& node) {
  const Half d;
  return {hn::Load(d, node.min), hn::Load(d, node.max)};
}

HWY_INLINE bool NodeOverlaps(const Sought& sought, const DbvtNode& node) {
  const Half d;
  const auto below = hn::Le(hn::Load(d, node.min), sought.max);
  const auto above = hn::Ge(hn::Load(d, node.max), sought.min);
  const auto not_coordinates = hn::Not(hn::FirstN(d, 3));
  return hn::AllTrue(d, hn::Or(hn::And(below, above), not_coordinates));
}

HWY_INLINE bool PackedOverlap(const PackedBox& a, const PackedBox& b) {
  const Half d;
  const auto below = hn::Le(hn::Load(d, a.min), hn::Load(d, b.max));
  const auto above = hn::Ge(hn::Load(d, a.max), hn::Load(d, b.min));
  return hn::AllTrue(d, hn::And(below, above));
}

#endif

// Calls on_leaf for each leaf below `start` that overlaps, `start` itself included. Returns the
// nodes looked at.
template <class OnLeaf>
HWY_INLINE uint64_t Walk(const DbvtNode* HWY_RESTRICT nodes, uint32_t leaf_count, uint32_t start,
                         const Sought& sought, const OnLeaf& on_leaf) {
  uint32_t stack[DbvtTree::kStackSize];
  size_t waiting = 0;
  uint64_t looked_at = 1;
  stack[waiting] = start;
  waiting += NodeOverlaps(sought, nodes[start]) ? 1 : 0;
  while (waiting > 0) {
    const uint32_t node = stack[--waiting];
    if (node < leaf_count) {
      on_leaf(node);
      continue;
    }
    const uint32_t first = nodes[node].first;
    const uint32_t second = nodes[node].second;
    // Written always, kept by count: whether a child overlaps is a coin toss to the branch
    // predictor.
    stack[waiting] = second;
    waiting += NodeOverlaps(sought, nodes[second]) ? 1 : 0;
    stack[waiting] = first;
    waiting += NodeOverlaps(sought, nodes[first]) ? 1 : 0;
    looked_at += 2;
  }
  return looked_at;
}

// Each leaf against the right siblings on its way up: so each pair is met once, at its lowest
// common ancestor.
uint64_t LeafPairs(const DbvtTree& tree, PairBuffer& out) {
  const DbvtNode* const nodes = tree.nodes();
  const uint32_t leaf_count = static_cast<uint32_t>(tree.leaf_count());
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (const uint32_t leaf : tree.order()) {
    const Sought sought = Seek(nodes[leaf]);
    const auto on_leaf = [&](uint32_t other) HWY_ATTR { cursor.Append(leaf, other); };
    uint32_t node = leaf;
    for (uint32_t above = tree.parent(node); above != DbvtTree::kNone; above = tree.parent(node)) {
      if (nodes[above].first == node) {
        checks += Walk(nodes, leaf_count, nodes[above].second, sought, on_leaf);
      }
      node = above;
    }
  }
  cursor.Flush();
  return checks;
}

uint64_t LeafPairsOf(const DbvtTree& tree, std::span<const uint32_t> leaves,
                     const uint8_t* is_listed, PairBuffer& out) {
  const DbvtNode* const nodes = tree.nodes();
  const uint32_t leaf_count = static_cast<uint32_t>(tree.leaf_count());
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (const uint32_t leaf : leaves) {
    if (!tree.Contains(leaf)) continue;
    const auto on_leaf = [&](uint32_t other) HWY_ATTR {
      // Of two listed leaves the lower one reports.
      if (other > leaf || (other < leaf && is_listed[other] == 0)) cursor.Append(leaf, other);
    };
    checks += Walk(nodes, leaf_count, tree.root(), Seek(nodes[leaf]), on_leaf);
  }
  cursor.Flush();
  return checks;
}

uint64_t Overlapping(std::span<const OverlapPair> candidates, const PackedBox* HWY_RESTRICT boxes,
                     PairBuffer& out) {
  OverlapPair* const kept = out.EnsureRoom(candidates.size());
  size_t count = 0;
  for (const OverlapPair& pair : candidates) {
    kept[count] = pair;
    count += PackedOverlap(boxes[pair.a], boxes[pair.b]) ? 1 : 0;
  }
  out.Advance(count);
  return candidates.size();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(LeafPairs);
HWY_EXPORT(LeafPairsOf);
HWY_EXPORT(Overlapping);

uint64_t FindLeafPairs(const DbvtTree& tree, PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(LeafPairs)(tree, out);
}

uint64_t FindLeafPairsOf(const DbvtTree& tree, std::span<const uint32_t> leaves,
                         const uint8_t* is_listed, PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(LeafPairsOf)(tree, leaves, is_listed, out);
}

uint64_t KeepOverlapping(std::span<const OverlapPair> candidates, const PackedBox* boxes,
                         PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(Overlapping)(candidates, boxes, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
