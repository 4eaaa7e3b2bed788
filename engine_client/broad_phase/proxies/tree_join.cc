// Finds overlaps between the boxes of two trees. For each block of 16 leaves of one tree it
// descends the other tree once, and continues like KDTree's search (kd/leaf_search-inl.h). If the
// boxes of a block are far apart, the block's bounds overlap many leaves that none of its boxes
// overlaps. The search then descends for each leaf separately, and if the same holds for a leaf,
// for each of its boxes.
#include <algorithm>

#include "engine_client/broad_phase/proxies/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/proxies/tree_join.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
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

class TreeJoin {
 public:
  TreeJoin(const LeafTree::View& leaves, const LeafTree::View& tree, uint32_t other_bit,
           PairBuffer& out, StopRequest* stop)
      : own_(leaves), tree_(tree), search_(leaves, tree, other_bit, out, stop) {}

  // Finds the pairs of the leaves [begin, end), at most 16.
  void Run(size_t begin, size_t end) {
    const BoxLanes& bounds = own_.levels[1];
    if (SearchTogether(begin, end, BoundsOfLeaves(bounds, begin, end), kMaxNodesOfBlock)) return;
    for (size_t leaf = begin; leaf < end; ++leaf) {
      if (!SearchTogether(leaf, leaf + 1, BoxAt(bounds, leaf), kMaxNodesOfLeaf)) SearchApart(leaf);
    }
  }

  bool Ends() { return search_.Ends(); }
  uint64_t Finish() { return search_.Finish(); }

 private:
  // The maximum number of nodes of 16 leaves that the bounds of a block or of a leaf may overlap.
  // With more nodes, separate searches (for each leaf of the block, or each box of the leaf) take
  // less time.
  static constexpr size_t kMaxNodesOfBlock = 16;
  static constexpr size_t kMaxNodesOfLeaf = 8;
  static constexpr size_t kMeetings = 256;

  // A box that overlaps the bounds of a leaf of the tree. `lane` is the box's lane in its own leaf.
  struct Meeting {
    uint32_t lane;
    uint32_t leaf;
  };

  // Finds the pairs of the leaves [begin, end) in one search with their common bounds. Returns
  // false without a result if the bounds overlap more than `max_nodes` nodes.
  bool SearchTogether(size_t begin, size_t end, const Aabb& bounds, size_t max_nodes) {
    uint32_t nodes[kMaxNodesOfBlock + LeafTree::kWidth] = {0};
    const size_t count = tree_.top == 1 ? 1 : FindNodes(bounds, max_nodes, nodes);
    if (count > max_nodes) return false;
    search_.BeginBlock(begin, end);
    for (size_t k = 0; k < count; ++k) search_.AddNear(bounds, FirstChild(2, nodes[k]));
    search_.AddChecks(count * LeafTree::kWidth);
    search_.TestNear();
    return true;
  }

  // Lists the nodes directly above the leaves that overlap the bounds. Ends early, with a count
  // above `max_nodes`, if there are more.
  size_t FindNodes(const Aabb& bounds, size_t max_nodes, uint32_t* nodes) {
    size_t count = 0;
    const uint64_t groups = Descend(
        tree_, 2,
        [&](size_t level, size_t base, FoundGroup& found) HWY_ATTR {
          found.count = 0;
          if (count <= max_nodes) CollectOverlapping(bounds, tree_.levels[level], base, found);
        },
        [&](const FoundGroup& found) {
          if (count > max_nodes) return;
          std::copy_n(found.entry, found.count, nodes + count);
          count += found.count;
        });
    search_.AddChecks(groups * LeafTree::kWidth);
    return count;
  }

  // Searches for each box of the leaf separately. While it descends for other boxes, it prefetches
  // the leaves that a box overlaps.
  void SearchApart(size_t leaf) {
    const BoxLanes boxes = LanesOf(own_.leaves[leaf]);
    for (uint32_t lane = 0; lane < LeafTree::kWidth && !Ends(); ++lane) {
      const Aabb box = BoxAt(boxes, lane);
      if (!IsValid(box)) continue;
      const uint64_t groups = Descend(
          tree_, 1,
          [&](size_t level, size_t base, FoundGroup& found)
              HWY_ATTR { CollectOverlapping(box, tree_.levels[level], base, found); },
          [&](const FoundGroup& found) HWY_ATTR { Meet(leaf, lane, found); });
      search_.AddChecks(groups * LeafTree::kWidth);
    }
    TestMeetings(leaf);
  }

  HWY_INLINE void Meet(size_t leaf, uint32_t lane, const FoundGroup& found) {
    if (meeting_count_ + found.count > kMeetings) TestMeetings(leaf);
    for (size_t k = 0; k < found.count; ++k) {
      meetings_[meeting_count_++] = {lane, found.entry[k]};
      search_.Prefetch(found.entry[k]);
    }
  }

  void TestMeetings(size_t leaf) {
    const LeafBlock& own = own_.leaves[leaf];
    for (size_t k = 0; k < meeting_count_; ++k) {
      const Meeting& meeting = meetings_[k];
      search_.TestBox(BoxAt(LanesOf(own), meeting.lane), own.id[meeting.lane], meeting.leaf);
    }
    meeting_count_ = 0;
  }

  const LeafTree::View& own_;
  const LeafTree::View& tree_;
  LeafSearch<false> search_;
  size_t meeting_count_ = 0;
  Meeting meetings_[kMeetings];
};

uint64_t JoinTrees(const LeafTree::View& leaves, size_t begin, size_t end,
                   const LeafTree::View& tree, uint32_t other_bit, PairBuffer& out,
                   StopRequest* stop) {
  TreeJoin join(leaves, tree, other_bit, out, stop);
  for (size_t first = begin; first < end && !join.Ends(); first += LeafTree::kWidth) {
    join.Run(first, std::min(end, first + LeafTree::kWidth));
  }
  return join.Finish();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(JoinTrees);

uint64_t FindPairsBetween(const LeafTree::View& leaves, size_t begin, size_t end,
                          const LeafTree::View& tree, uint32_t other_bit, PairBuffer& out,
                          StopRequest* stop) {
  if (tree.top == 0 || begin == end) return 0;
  return HWY_DYNAMIC_DISPATCH(JoinTrees)(leaves, begin, end, tree, other_bit, out, stop);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
