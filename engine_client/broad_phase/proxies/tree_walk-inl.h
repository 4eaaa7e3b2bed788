// The descent that all searches in a tree share, compiled for every target of Highway. Include
// after hwy/foreach_target.h.
#if defined(SWEEPSTAKE_TREE_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_TREE_WALK_INL_H_
#undef SWEEPSTAKE_TREE_WALK_INL_H_
#else
#define SWEEPSTAKE_TREE_WALK_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Indices of up to 16 entries of a level, with room for a whole register behind the last one.
struct FoundGroup {
  uint32_t entry[2 * LeafTree::kWidth];
  size_t count = 0;
};

// Appends the indices of the lanes set in `hits`, where lane 0 is index `at`.
HWY_INLINE void AppendHits(Lanes16 d, hn::Mask<Lanes16> hits, size_t at, FoundGroup& found) {
  const hn::RebindToUnsigned<Lanes16> du;
  const auto index = NumbersFrom(du, at);
  hn::StoreU(CompressLanes(index, hn::RebindMask(du, hits)), du, found.entry + found.count);
  found.count += hn::CountTrue(d, hits);
}

// Lists which of the 16 entries from `base` on overlap `box`.
HWY_INLINE void CollectOverlapping(const Aabb& box, const BoxLanes& lanes, size_t base,
                                   FoundGroup& found) {
  const Lanes16 d;
  found.count = 0;
  for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
    AppendHits(d, Hits(d, box, lanes, at), at, found);
  }
}

// Returns the index on `level` at which the 16 children of a node begin.
HWY_INLINE size_t FirstChild(size_t level, size_t node) {
  return node * (level == 0 ? LeafBlock::kStride : LeafTree::kWidth);
}

// Descends depth first to the level `bottom`. collect(level, base, found) lists which of 16 entries
// of a level to enter; take(found) receives the entries of the lowest level. Returns the number of
// groups of 16 that were collected.
template <class Collect, class Take>
HWY_INLINE uint64_t Descend(const LeafTree::View& tree, size_t bottom, const Collect& collect,
                            const Take& take) {
  if (tree.top == 0) return 0;
  FoundGroup waiting[LeafTree::kMaxLevels + 1];
  size_t level = tree.top;
  collect(level, 0, waiting[level]);
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
    collect(level, FirstChild(level, node), waiting[level]);
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
