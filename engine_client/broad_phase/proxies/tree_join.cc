// Overlaps between the boxes of two trees.
//
// For 16 leaves of the one tree together, the leaves of the other that are near them are brought up
// once; each of the 16 is then tested against that short list, the boxes of the leaves found
// against its bounds, and the boxes found against its 16 boxes at once. Descending for every leaf
// alone takes twice as long: what one level says must be waited for before the next is asked.
#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/proxies/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/proxies/tree_join.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/proxies/tree_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

constexpr size_t kGroup = LeafTree::kWidth;
// Near leaves that are looked at together; usual are 40.
constexpr size_t kNearRoom = 256;
// Of a stored mask of up to 16 lanes.
constexpr size_t kMaskBytes = 2;

class TreeJoin {
 public:
  TreeJoin(const TreeView& leaves, const TreeView& tree, uint32_t other_bit, PairBuffer& out)
      : boxes_(leaves.levels[0]),
        bounds_(leaves.levels[1]),
        tree_(tree),
        others_(tree.levels[0]),
        other_bit_(other_bit),
        cursor_(out) {}

  // The leaves [begin, end), 16 at most.
  void Run(size_t begin, size_t end) {
    const Aabb around = BoundsOfAll(begin, end);
    near_count_ = 0;
    const uint64_t groups = Descend(
        tree_, 1,
        [&](const BoxLanes& lanes, size_t base, FoundGroup& found)
            HWY_ATTR { CollectOverlapping(around, lanes, base, found); },
        [&](const FoundGroup& found) HWY_ATTR {
          if (near_count_ + kGroup > kNearRoom) TestNear(begin, end);
          for (size_t k = 0; k < found.count; ++k) AddNear(found.entry[k]);
        });
    checks_ += groups * kGroup;
    TestNear(begin, end);
  }

  uint64_t Finish() {
    cursor_.Flush();
    return checks_;
  }

 private:
  Aabb BoundsOfAll(size_t begin, size_t end) const {
    Aabb all = BoxAt(bounds_, begin);
    for (size_t leaf = begin + 1; leaf < end; ++leaf) {
      for (size_t axis = 0; axis < 3; ++axis) {
        all.min[axis] = std::min(all.min[axis], bounds_.min[axis][leaf]);
        all.max[axis] = std::max(all.max[axis], bounds_.max[axis][leaf]);
      }
    }
    return all;
  }

  void AddNear(uint32_t leaf) {
    const BoxLanes& leaves = tree_.levels[1];
    for (size_t axis = 0; axis < 3; ++axis) {
      near_min_[axis][near_count_] = leaves.min[axis][leaf];
      near_max_[axis][near_count_] = leaves.max[axis][leaf];
    }
    near_leaf_[near_count_++] = leaf;
  }

  void TestNear(size_t begin, size_t end) {
    // A register of sentinels behind the last.
    std::fill_n(near_min_[0] + near_count_, kGroup, std::numeric_limits<float>::infinity());
    for (size_t leaf = begin; leaf < end; ++leaf) {
      const Aabb around = BoxAt(bounds_, leaf);
      TestBoxes(leaf * kGroup, FindBoxes(around, FindLeaves(around)));
    }
    near_count_ = 0;
  }

  // Which of the near leaves overlap `around`; how many.
  size_t FindLeaves(const Aabb& around) {
    const GroupTag d;
    const hn::RebindToUnsigned<GroupTag> du;
    const BoxLanes near = {{near_min_[0], near_min_[1], near_min_[2]},
                           {near_max_[0], near_max_[1], near_max_[2]},
                           near_leaf_,
                           near_count_};
    size_t count = 0;
    for (size_t at = 0; at < near_count_; at += hn::Lanes(d)) {
      const auto hits = hn::RebindMask(du, Hits(d, around, near, at));
      hn::StoreU(hn::Compress(hn::LoadU(du, near_leaf_ + at), hits), du, leaves_ + count);
      count += hn::CountTrue(du, hits);
    }
    checks_ += near_count_;
    return count;
  }

  // Which boxes of the first leaves found overlap `around`; how many.
  size_t FindBoxes(const Aabb& around, size_t leaf_count) {
    const GroupTag d;
    const hn::RebindToUnsigned<GroupTag> du;
    const BoxLanes others = others_;
    size_t count = 0;
    for (size_t k = 0; k < leaf_count; ++k) {
      const size_t base = size_t{leaves_[k]} * kGroup;
      for (size_t at = base; at < base + kGroup; at += hn::Lanes(d)) {
        const auto hits = hn::RebindMask(du, Hits(d, around, others, at));
        const auto slot = hn::Iota(du, static_cast<uint32_t>(at));
        hn::StoreU(hn::Compress(slot, hits), du, found_ + count);
        count += hn::CountTrue(du, hits);
      }
    }
    checks_ += leaf_count * kGroup;
    return count;
  }

  // One axis of boxes kept in registers against one of the others.
  template <class D>
  HWY_INLINE static hn::Mask<D> AxisHitsOfHeld(D d, hn::Vec<D> min, hn::Vec<D> max,
                                               const BoxLanes& others, size_t axis, size_t slot) {
    return hn::And(hn::Le(min, hn::Set(d, others.max[axis][slot])),
                   hn::Ge(max, hn::Set(d, others.min[axis][slot])));
  }

  // The 16 boxes from `first` on against the boxes found.
  void TestBoxes(size_t first, size_t found_count) {
    const GroupTag d;
    const size_t step = hn::Lanes(d);
    const BoxLanes boxes = boxes_;
    const BoxLanes others = others_;
    for (size_t at = first; at < first + kGroup; at += step) {
      const auto min0 = hn::LoadU(d, boxes.min[0] + at);
      const auto min1 = hn::LoadU(d, boxes.min[1] + at);
      const auto min2 = hn::LoadU(d, boxes.min[2] + at);
      const auto max0 = hn::LoadU(d, boxes.max[0] + at);
      const auto max1 = hn::LoadU(d, boxes.max[1] + at);
      const auto max2 = hn::LoadU(d, boxes.max[2] + at);
      size_t hit_count = 0;
      for (size_t k = 0; k < found_count; ++k) {
        const size_t slot = found_[k];
        const auto hits = hn::And(hn::And(AxisHitsOfHeld(d, min0, max0, others, 0, slot),
                                          AxisHitsOfHeld(d, min1, max1, others, 1, slot)),
                                  AxisHitsOfHeld(d, min2, max2, others, 2, slot));
        hn::StoreMaskBits(d, hits, hit_lanes_ + hit_count * kMaskBytes);
        hit_slot_[hit_count] = found_[k];
        hit_count += hn::AllFalse(d, hits) ? 0 : 1;
      }
      StorePairs(at, hit_count);
    }
    checks_ += found_count * kGroup;
  }

  // Apart from the tests: half the boxes found hit none of a register's boxes, and storing is what
  // takes longest.
  void StorePairs(size_t at, size_t hit_count) {
    const GroupTag d;
    const uint32_t* const other_ids = others_.id;
    const uint32_t* const ids = boxes_.id;
    for (size_t k = 0; k < hit_count; ++k) {
      const auto hits = hn::LoadMaskBits(d, hit_lanes_ + k * kMaskBytes);
      const uint32_t other = other_bit_ | other_ids[hit_slot_[k]];
      cursor_.Advance(StoreHits(d, hits, other, ids + at, cursor_.Room(hn::Lanes(d))));
    }
  }

  const BoxLanes boxes_;
  const BoxLanes bounds_;
  const TreeView& tree_;
  const BoxLanes others_;
  const uint32_t other_bit_;
  PairCursor cursor_;
  uint64_t checks_ = 0;
  size_t near_count_ = 0;
  // Compressing stores may overrun each by a register.
  float near_min_[3][kNearRoom + kGroup];
  float near_max_[3][kNearRoom + kGroup];
  uint32_t near_leaf_[kNearRoom + kGroup];
  uint32_t leaves_[kNearRoom + kGroup];
  uint32_t found_[kNearRoom * kGroup + kGroup];
  uint32_t hit_slot_[kNearRoom * kGroup + kGroup];
  uint8_t hit_lanes_[kMaskBytes * (kNearRoom * kGroup + kGroup)];
};

uint64_t JoinTrees(const TreeView& leaves, size_t begin, size_t end, const TreeView& tree,
                   uint32_t other_bit, PairBuffer& out) {
  TreeJoin join(leaves, tree, other_bit, out);
  for (size_t first = begin; first < end; first += kGroup) {
    join.Run(first, std::min(end, first + kGroup));
  }
  return join.Finish();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(JoinTrees);

uint64_t FindPairsBetween(const TreeView& leaves, size_t begin, size_t end, const TreeView& tree,
                          uint32_t other_bit, PairBuffer& out) {
  if (tree.top == 0 || begin == end) return 0;
  return HWY_DYNAMIC_DISPATCH(JoinTrees)(leaves, begin, end, tree, other_bit, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
