// The descent that all walks share, for every target of Highway. Include after
// hwy/foreach_target.h.
#if defined(SWEEPSTAKE_TREE_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_TREE_WALK_INL_H_
#undef SWEEPSTAKE_TREE_WALK_INL_H_
#else
#define SWEEPSTAKE_TREE_WALK_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "engine_client/broad_phase/proxies/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

using GroupTag = hn::CappedTag<float, LeafTree::kWidth>;

// 16 entries, and a register that a compressing store may overrun.
struct FoundGroup {
  uint32_t entry[2 * LeafTree::kWidth];
  size_t count = 0;
};

// Appends the indices of the lanes set in `hits`, of which lane 0 is `at`.
template <class D>
HWY_INLINE void AppendHits(D d, hn::Mask<D> hits, size_t at, FoundGroup& found) {
  const hn::RebindToUnsigned<D> du;
  const auto index = hn::Iota(du, static_cast<uint32_t>(at));
  hn::StoreU(hn::Compress(index, hn::RebindMask(du, hits)), du, found.entry + found.count);
  found.count += hn::CountTrue(d, hits);
}

// Which of the 16 entries from `base` on overlap `box`.
HWY_INLINE void CollectOverlapping(const Aabb& box, const BoxLanes& lanes, size_t base,
                                   FoundGroup& found) {
  const GroupTag d;
  found.count = 0;
  for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
    AppendHits(d, Hits(d, box, lanes, at), at, found);
  }
}

// Depth first down to the level `bottom`: collect(lanes, base, found) says which of 16 entries of a
// level are entered, take(found) takes those of the last. Returns the groups that were asked.
template <class Collect, class Take>
HWY_INLINE uint64_t Descend(const TreeView& tree, size_t bottom, const Collect& collect,
                            const Take& take) {
  if (tree.top == 0) return 0;
  FoundGroup waiting[LeafTree::kMaxLevels + 1];
  size_t level = tree.top;
  collect(tree.levels[level], 0, waiting[level]);
  for (uint64_t groups = 1;; ++groups) {
    if (level == bottom) {
      if (waiting[level].count > 0) take(waiting[level]);
      waiting[level].count = 0;
    }
    while (waiting[level].count == 0) {
      if (level == tree.top) return groups;
      ++level;
    }
    const size_t node = waiting[level].entry[--waiting[level].count];
    --level;
    collect(tree.levels[level], node * LeafTree::kWidth, waiting[level]);
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
