// Overlaps between the boxes of two trees: a block of 16 leaves of the one goes down the other, and
// the rest is the search that KDTree uses (kd/leaf_search-inl.h).
#include <algorithm>

#include "engine_client/broad_phase/proxies/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/proxies/tree_join.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// What follows must come after foreach_target.h.
#include "engine_client/broad_phase/kd/leaf_search-inl.h"
#include "engine_client/broad_phase/proxies/tree_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

Aabb BoundsOfLeaves(const BoxLanes& leaves, size_t begin, size_t end) {
  Aabb all = BoxAt(leaves, begin);
  for (size_t leaf = begin + 1; leaf < end; ++leaf) {
    for (size_t axis = 0; axis < 3; ++axis) {
      all.min[axis] = std::min(all.min[axis], leaves.min[axis][leaf]);
      all.max[axis] = std::max(all.max[axis], leaves.max[axis][leaf]);
    }
  }
  return all;
}

uint64_t JoinTrees(const LeafTree::View& leaves, size_t begin, size_t end,
                   const LeafTree::View& tree, uint32_t other_bit, PairBuffer& out) {
  LeafSearch<false> search(leaves, tree, other_bit, out);
  for (size_t first = begin; first < end; first += LeafTree::kWidth) {
    const size_t last = std::min(end, first + LeafTree::kWidth);
    const Aabb bounds = BoundsOfLeaves(leaves.levels[1], first, last);
    search.BeginBlock(first, last);
    const uint64_t groups = Descend(
        tree, 1,
        [&](size_t level, size_t base, FoundGroup& found) HWY_ATTR {
          if (level > 1) return CollectOverlapping(bounds, tree.levels[level], base, found);
          search.AddNear(bounds, base);
        },
        [](const FoundGroup&) {});
    search.AddChecks(groups * LeafTree::kWidth);
    search.TestNear();
  }
  return search.Finish();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(JoinTrees);

uint64_t FindPairsBetween(const LeafTree::View& leaves, size_t begin, size_t end,
                          const LeafTree::View& tree, uint32_t other_bit, PairBuffer& out) {
  if (tree.top == 0 || begin == end) return 0;
  return HWY_DYNAMIC_DISPATCH(JoinTrees)(leaves, begin, end, tree, other_bit, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
