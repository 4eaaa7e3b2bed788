// The search of KDTree. For each block of 16 leaves it descends the tree once, and finds the pairs
// of the block's boxes with one another and with the boxes of later blocks.
#include <algorithm>
#include <bit>
#include <limits>

#include "engine_client/broad_phase/kd/leaf_tree.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/kd_search.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/kd/leaf_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

class BlockSearch {
 public:
  BlockSearch(const LeafTree::View& tree, PairBuffer& out, StopRequest* stop)
      : tree_(tree), leaves_(tree, tree, 0, out, stop) {}

  void Run(uint32_t block) {
    const size_t first = size_t{block} * LeafTree::kWidth;
    block_ = block;
    bounds_ = BoundsOfBlock();
    leaves_.BeginBlock(first, std::min(first + LeafTree::kWidth, tree_.levels[1].count));
    Descend(tree_.top, 0);
    leaves_.TestNear();
  }

  bool Ends() { return leaves_.Ends(); }
  uint64_t Finish() { return leaves_.Finish(); }

 private:
  // Returns the bounds of the block. In a tree without nodes above its leaves, the only block holds
  // all leaves and gets unlimited bounds.
  Aabb BoundsOfBlock() const {
    if (tree_.top > 1) return BoxAt(tree_.levels[2], block_);
    constexpr float kMax = std::numeric_limits<float>::max();
    return {{-kMax, -kMax, -kMax}, {kMax, kMax, kMax}};
  }

  // Adds leaves below `node` to the near list if they overlap the bounds of the block and belong to
  // this block or a later one. The 16 children of `node` are on `level`.
  void Descend(size_t level, uint32_t node) {
    const size_t base = size_t{node} * LeafTree::kWidth;
    leaves_.AddChecks(LeafTree::kWidth);
    if (level == 1) return leaves_.AddNear(bounds_, base);
    const Lanes16 d;
    const BoxLanes& lanes = tree_.levels[level];
    // `first` is the ancestor of the block on this level. All nodes before it have been searched
    // already.
    const uint32_t first = block_ >> (LeafTree::kWidthBits * static_cast<uint32_t>(level - 2));
    for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
      uint32_t hits = BitsOfMask(d, Hits(d, bounds_, lanes, at));
      for (; hits != 0; hits &= hits - 1) {
        const auto child =
            static_cast<uint32_t>(at) + static_cast<uint32_t>(std::countr_zero(hits));
        if (child >= first) Descend(level - 1, child);
      }
    }
  }

  const LeafTree::View& tree_;
  LeafSearch<true> leaves_;
  uint32_t block_ = 0;
  Aabb bounds_{};
};

uint64_t SearchBlocks(const LeafTree::View& tree, size_t begin, size_t end, PairBuffer& out,
                      StopRequest* stop) {
  BlockSearch search(tree, out, stop);
  for (size_t block = begin; block < end && !search.Ends(); ++block) {
    search.Run(static_cast<uint32_t>(block));
  }
  return search.Finish();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(SearchBlocks);

uint64_t LeafTree::FindPairs(size_t begin, size_t end, PairBuffer& out, StopRequest* stop) const {
  if (begin == end) return 0;
  return HWY_DYNAMIC_DISPATCH(SearchBlocks)(view_, begin, end, out, stop);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
