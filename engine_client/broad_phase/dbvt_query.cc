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

// A corner of a box: half a register, or where there is none, its address. Never a member of
// anything: registers of unknown size cannot be one.
#if HWY_TARGET == HWY_SCALAR

using Corner = const float*;

HWY_INLINE Corner LoadCorner(const float* corner) { return corner; }

HWY_INLINE bool CornersOverlap(Corner min, Corner max, Corner other_min, Corner other_max) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap &= other_min[axis] <= max[axis];
    overlap &= other_max[axis] >= min[axis];
  }
  return overlap;
}

#else

using Half = hn::FixedTag<float, 4>;
using Corner = hn::Vec<Half>;

HWY_INLINE Corner LoadCorner(const float* corner) { return hn::Load(Half(), corner); }

HWY_INLINE bool CornersOverlap(Corner min, Corner max, Corner other_min, Corner other_max) {
  const Half d;
  const auto overlap = hn::And(hn::Le(other_min, max), hn::Ge(other_max, min));
  // The fourth lanes of nodes hold children.
  const auto not_coordinates = hn::Not(hn::FirstN(d, 3));
  return hn::AllTrue(d, hn::Or(overlap, not_coordinates));
}

#endif

HWY_INLINE bool NodeOverlaps(Corner min, Corner max, const DbvtNode& node) {
  return CornersOverlap(min, max, LoadCorner(node.min), LoadCorner(node.max));
}

HWY_INLINE bool PackedOverlap(const PackedBox& a, const PackedBox& b) {
  return CornersOverlap(LoadCorner(a.min), LoadCorner(a.max), LoadCorner(b.min), LoadCorner(b.max));
}

// Calls on_leaf for each leaf below `start` that overlaps, `start` itself included. Returns the
// nodes looked at.
template <class OnLeaf>
HWY_INLINE uint64_t Walk(const DbvtNode* HWY_RESTRICT nodes, uint32_t leaf_count, uint32_t start,
                         Corner min, Corner max, const OnLeaf& on_leaf) {
  uint32_t stack[DbvtTree::kStackSize];
  size_t waiting = 0;
  uint64_t looked_at = 1;
  stack[waiting] = start;
  waiting += NodeOverlaps(min, max, nodes[start]) ? 1 : 0;
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
    waiting += NodeOverlaps(min, max, nodes[second]) ? 1 : 0;
    stack[waiting] = first;
    waiting += NodeOverlaps(min, max, nodes[first]) ? 1 : 0;
    looked_at += 2;
  }
  return looked_at;
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
    checks += Walk(nodes, leaf_count, tree.root(), LoadCorner(nodes[leaf].min),
                   LoadCorner(nodes[leaf].max), on_leaf);
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

HWY_EXPORT(LeafPairsOf);
HWY_EXPORT(Overlapping);

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
