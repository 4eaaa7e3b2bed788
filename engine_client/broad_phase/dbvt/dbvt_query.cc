#include "engine_client/broad_phase/dbvt/dbvt_query.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/dbvt/dbvt_query.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/common/stop_poll.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

constexpr uint32_t kWidth = DbvtTree::kWidth;

HWY_INLINE BoxLanes LanesOf(const DbvtNode& node) {
  return {{node.min[0], node.min[1], node.min[2]},
          {node.max[0], node.max[1], node.max[2]},
          node.child,
          kWidth};
}

// Lists in `found` the children from lane `first` on that overlap `box`, and returns their number.
// May write up to one register behind the last entry.
HWY_INLINE size_t CollectChildren(const Aabb& box, const DbvtNode& node, uint32_t first,
                                  uint32_t* found) {
  const Lanes16 d;
  const hn::RebindToUnsigned<Lanes16> du;
  const BoxLanes lanes = LanesOf(node);
  size_t count = 0;
  for (size_t at = 0; at < kWidth; at += hn::Lanes(d)) {
    const auto hits = hn::And(SlotsFrom(d, first, at), Hits(d, box, lanes, at));
    hn::StoreU(CompressLanes(hn::Load(du, node.child + at), hn::RebindMask(du, hits)), du,
               found + count);
    count += hn::CountTrue(d, hits);
  }
  return count;
}

// Lists in `found` the slots (leaf · kWidth + lane) of the leaf's boxes that overlap `box`, and
// returns their number. May write up to one register behind the last entry.
HWY_INLINE size_t CollectSlots(const Aabb& box, const DbvtNode* nodes, uint32_t leaf,
                               uint32_t* found) {
  const Lanes16 d;
  const hn::RebindToUnsigned<Lanes16> du;
  const BoxLanes lanes = LanesOf(nodes[leaf]);
  size_t count = 0;
  for (size_t at = 0; at < kWidth; at += hn::Lanes(d)) {
    const auto hits = Hits(d, box, lanes, at);
    const auto slots = NumbersFrom(du, leaf * kWidth + at);
    hn::StoreU(CompressLanes(slots, hn::RebindMask(du, hits)), du, found + count);
    count += hn::CountTrue(d, hits);
  }
  return count;
}

// Tests the leaf's boxes, a register at a time, against the boxes in `slots`. With kSelf it tests
// each of the leaf's boxes against the lanes behind it instead. With 128-bit registers, copying the
// other box's faces to all lanes costs more than comparing them. The copies are therefore reused
// for all registers of the leaf. With wider registers, the leaf's faces stay loaded instead.
template <bool kSelf>
HWY_INLINE void TestSlots(const DbvtNode* HWY_RESTRICT nodes, const DbvtNode& leaf,
                          size_t leaf_size, const uint32_t* slots, size_t slot_count,
                          PairCursor& cursor) {
  const Lanes16 d;
  const size_t step = hn::Lanes(d);
#if HWY_MAX_BYTES == 16
  for (size_t k = 0; k < (kSelf ? leaf_size : slot_count); ++k) {
    const DbvtNode& node = kSelf ? leaf : nodes[slots[k] / kWidth];
    const size_t lane = kSelf ? k : slots[k] % kWidth;
    const Aabb box = BoxAt(LanesOf(node), lane);
    OverlapPair* const room = cursor.Room(kWidth);
    OverlapPair* out = room;
    for (size_t at = kSelf ? (k + 1) / step * step : 0; at < leaf_size; at += step) {
      auto hits = Hits(d, box, LanesOf(leaf), at);
      if constexpr (kSelf) hits = hn::And(hits, SlotsFrom(d, k + 1, at));
      out += StoreHits(d, hits, node.child[lane], leaf.child + at, out);
    }
    cursor.Advance(static_cast<size_t>(out - room));
  }
#else
  for (size_t at = 0; at < leaf_size; at += step) {
    const auto min0 = hn::Load(d, leaf.min[0] + at);
    const auto min1 = hn::Load(d, leaf.min[1] + at);
    const auto min2 = hn::Load(d, leaf.min[2] + at);
    const auto max0 = hn::Load(d, leaf.max[0] + at);
    const auto max1 = hn::Load(d, leaf.max[1] + at);
    const auto max2 = hn::Load(d, leaf.max[2] + at);
    const size_t count = kSelf ? std::min(leaf_size, at + step) : slot_count;
    for (size_t k = 0; k < count; ++k) {
      const DbvtNode& node = kSelf ? leaf : nodes[slots[k] / kWidth];
      const size_t lane = kSelf ? k : slots[k] % kWidth;
      auto hits = HeldHits<kWidth>(d, min0, min1, min2, max0, max1, max2, &node.min[0][lane],
                                   &node.max[0][lane]);
      if constexpr (kSelf) hits = hn::And(hits, SlotsFrom(d, k + 1, at));
      cursor.Advance(StoreHits(d, hits, node.child[lane], leaf.child + at, cursor.Room(step)));
    }
  }
#endif
}

// The maximum number of pending nodes in a depth-first walk: all siblings on each level.
constexpr size_t kStackSize = DbvtTree::kMaxLevels * kWidth + kWidth;

// The search for the pairs of one leaf with the leaves after it. One list collects the leaves
// found, another the slots of the boxes found in them. A list is processed when it is full: the
// branches of one long loop are predicted better than the branches of many short loops.
struct DbvtSearch {
  DbvtSearch(const DbvtTree& tree, PairCursor& pairs)
      : nodes(tree.nodes()), links(tree.links()), cursor(pairs) {}

  static constexpr size_t kLeafCapacity = 64;
  static constexpr size_t kSlotCapacity = 256;

  const DbvtNode* nodes;
  const DbvtLink* links;
  PairCursor& cursor;
  uint32_t leaf = 0;
  uint32_t leaf_size = 0;
  Aabb bounds{};
  uint64_t checks = 0;
  size_t leaf_count = 0;
  size_t slot_count = 0;
  uint32_t leaves[kLeafCapacity + kWidth];
  uint32_t slots[kSlotCapacity + kWidth];
  uint32_t stack[kStackSize];
};

HWY_INLINE void TestFoundSlots(DbvtSearch& search) {
  TestSlots<false>(search.nodes, search.nodes[search.leaf], search.leaf_size, search.slots,
                   search.slot_count, search.cursor);
  search.checks += search.slot_count * kWidth;
  search.slot_count = 0;
}

// Prefetches a leaf, since in large trees the leaves are not in the cache.
HWY_INLINE void FetchAhead(const DbvtNode& leaf) {
  for (size_t axis = 0; axis < 3; ++axis) {
    hwy::Prefetch(leaf.min[axis]);
    hwy::Prefetch(leaf.max[axis]);
  }
  hwy::Prefetch(leaf.child);
}

HWY_INLINE void TestFoundLeaves(DbvtSearch& search) {
  for (size_t k = 0; k < search.leaf_count; ++k) {
    if (k + 3 < search.leaf_count) FetchAhead(search.nodes[search.leaves[k + 3]]);
    search.slot_count += CollectSlots(search.bounds, search.nodes, search.leaves[k],
                                      search.slots + search.slot_count);
    if (search.slot_count > DbvtSearch::kSlotCapacity) TestFoundSlots(search);
  }
  search.checks += search.leaf_count * kWidth;
  search.leaf_count = 0;
}

// Searches the subtrees of the children of `node` from the child in lane `first` on.
HWY_INLINE void SearchBelow(DbvtSearch& search, uint32_t node, uint32_t first) {
  size_t waiting = 0;
  for (;;) {
    search.checks += kWidth;
    if (search.links[node].level > 1) {
      waiting += CollectChildren(search.bounds, search.nodes[node], first, search.stack + waiting);
    } else {
      search.leaf_count += CollectChildren(search.bounds, search.nodes[node], first,
                                           search.leaves + search.leaf_count);
      if (search.leaf_count > DbvtSearch::kLeafCapacity) TestFoundLeaves(search);
    }
    if (waiting == 0) return;
    node = search.stack[--waiting];
    first = 0;
  }
}

// Tests a leaf against itself, then searches its later siblings, and then the later siblings of
// each of its ancestors.
HWY_INLINE void SearchLeaf(DbvtSearch& search, uint32_t group, uint32_t lane) {
  const DbvtNode* const nodes = search.nodes;
  search.leaf = nodes[group].child[lane];
  search.leaf_size = search.links[search.leaf].count;
  search.bounds = BoxAt(LanesOf(nodes[group]), lane);
  TestSlots<true>(nodes, nodes[search.leaf], search.leaf_size, nullptr, 0, search.cursor);
  search.checks += size_t{search.leaf_size} * kWidth;
  SearchBelow(search, group, lane + 1);
  for (uint32_t node = group; search.links[node].parent != DbvtTree::kNone;) {
    const DbvtLink& link = search.links[node];
    SearchBelow(search, link.parent, link.lane + 1U);
    node = link.parent;
  }
  TestFoundLeaves(search);
  TestFoundSlots(search);
}

// Searches the leaves of a group from `lane` on, until `max_checks` checks have been made. Returns
// the lane where it ended. Not inlined, since the caller's variables would occupy registers.
HWY_NOINLINE uint32_t SearchLeaves(DbvtSearch& search, uint32_t group, uint32_t lane,
                                   uint64_t max_checks) {
  const uint32_t count = search.links[group].count;
  for (; lane < count && search.checks < max_checks; ++lane) SearchLeaf(search, group, lane);
  return lane;
}

uint64_t GroupPairs(const DbvtTree& tree, std::span<const uint32_t> groups, PairBuffer& out,
                    StopRequest* stop) {
  StopPoll poll(stop, out);
  PairCursor cursor(out);
  DbvtSearch search(tree, cursor);
  for (const uint32_t group : groups) {
    const uint32_t count = search.links[group].count;
    for (uint32_t lane = 0; lane < count && !poll.Ends(search.checks);) {
      lane = SearchLeaves(search, group, lane, poll.next_question());
    }
  }
  cursor.Flush();
  return search.checks;
}

uint64_t PairsOf(const DbvtTree& tree, std::span<const uint32_t> objects, const Aabb* fat,
                 const uint8_t* is_listed, PairBuffer& out, StopRequest* stop) {
  const DbvtNode* const nodes = tree.nodes();
  const DbvtLink* const links = tree.links();
  StopPoll poll(stop, out);
  PairCursor cursor(out);
  uint64_t checks = 0;
  uint32_t stack[kStackSize];
  uint32_t met[2 * kWidth];
  for (const uint32_t object : objects) {
    if (poll.Ends(checks)) break;
    if (!tree.Contains(object)) continue;
    // Descends to the leaves that the object's enlarged box overlaps.
    size_t waiting = 0;
    stack[waiting++] = tree.root();
    while (waiting > 0) {
      const uint32_t node = stack[--waiting];
      checks += kWidth;
      if (links[node].level > 0) {
        waiting += CollectChildren(fat[object], nodes[node], 0, stack + waiting);
        continue;
      }
      const size_t met_count = CollectChildren(fat[object], nodes[node], 0, met);
      for (size_t k = 0; k < met_count; ++k) {
        // If both objects of a pair are listed, only the object with the lower index reports the
        // pair.
        if (met[k] > object || (met[k] < object && is_listed[met[k]] == 0)) {
          cursor.Append(object, met[k]);
        }
      }
    }
  }
  cursor.Flush();
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(GroupPairs);
HWY_EXPORT(PairsOf);

uint64_t FindGroupPairs(const DbvtTree& tree, std::span<const uint32_t> groups, PairBuffer& out,
                        StopRequest* stop) {
  return HWY_DYNAMIC_DISPATCH(GroupPairs)(tree, groups, out, stop);
}

uint64_t FindPairsOf(const DbvtTree& tree, std::span<const uint32_t> objects, const Aabb* fat,
                     const uint8_t* is_listed, PairBuffer& out, StopRequest* stop) {
  return HWY_DYNAMIC_DISPATCH(PairsOf)(tree, objects, fat, is_listed, out, stop);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
