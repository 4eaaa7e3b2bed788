#include "engine_client/broad_phase/kd/leaf_pairs.h"

#include <algorithm>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/leaf_pairs.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

using Lanes16 = hn::CappedTag<float, LeafTree::kWidth>;

constexpr size_t kWidth = LeafTree::kWidth;
// Leaves near a block that are looked at together; usual are 40.
constexpr size_t kNearRoom = 256;
// Boxes of those that overlap the bounds of one leaf.
constexpr size_t kFoundRoom = kNearRoom * kWidth;
// A box's place is its distance from the first one, in words.
constexpr size_t kBlockWords = sizeof(LeafBlock) / sizeof(float);
// Of a stored mask of up to 16 lanes.
constexpr size_t kMaskBytes = 2;

// Of each axis in turn, so that half the comparisons do not wait for the other half.
template <class D>
HWY_INLINE hn::Mask<D> Overlapping(D d, const Aabb& box, const BoxLanes& lanes, size_t at) {
  auto ends = hn::Le(hn::LoadU(d, lanes.min[0] + at), hn::Set(d, box.max[0]));
  auto begins = hn::Ge(hn::LoadU(d, lanes.max[0] + at), hn::Set(d, box.min[0]));
  for (size_t axis = 1; axis < 3; ++axis) {
    ends = Both(ends, hn::Le(hn::LoadU(d, lanes.min[axis] + at), hn::Set(d, box.max[axis])));
    begins = Both(begins, hn::Ge(hn::LoadU(d, lanes.max[axis] + at), hn::Set(d, box.min[axis])));
  }
  return hn::And(ends, begins);
}

// Lanes of indices above `index`, when lane 0 is index `at`.
template <class D>
HWY_INLINE hn::Mask<D> LanesAfter(D d, uint32_t index, size_t at) {
  const hn::RebindToUnsigned<D> du;
  const auto lane = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<uint32_t>(at)));
  return hn::RebindMask(d, hn::Gt(lane, hn::Set(du, index)));
}

class BlockSearch {
 public:
  BlockSearch(const LeafBlock* leaves, const LeafTree::Level* levels, size_t level_count,
              PairBuffer& out)
      : blocks_(leaves), levels_(levels), level_count_(level_count), cursor_(out) {}

  void Run(uint32_t block) {
    block_ = block;
    near_count_ = 0;
    own_leaves_pending_ = true;
    bounds_ = BoundsOfBlock();
    CollectBelow(level_count_, 0);
    TestNear();
  }

  uint64_t Finish() {
    cursor_.Flush();
    return checks_;
  }

 private:
  // A single level has no nodes that stand for blocks: its one block takes all leaves that hold
  // anything.
  Aabb BoundsOfBlock() const {
    if (level_count_ > 1) return BoxAt(AsLanes(levels_[1]), block_);
    constexpr float kMax = std::numeric_limits<float>::max();
    return {{-kMax, -kMax, -kMax}, {kMax, kMax, kMax}};
  }

  static BoxLanes AsLanes(const LeafTree::Level& level) {
    return {{level.min[0], level.min[1], level.min[2]},
            {level.max[0], level.max[1], level.max[2]},
            nullptr,
            level.count};
  }

  // The leaves of this block and later ones below a node, which stands one level above `level`'s
  // first.
  void CollectBelow(size_t level, uint32_t node) {
    const size_t base = size_t{node} * kWidth;
    if (level == 1) return CollectLeaves(base);
    const Lanes16 d;
    const BoxLanes lanes = AsLanes(levels_[level - 1]);
    const uint32_t first = block_ >> (LeafTree::kWidthBits * static_cast<uint32_t>(level - 2));
    checks_ += kWidth;
    for (size_t at = base; at < base + kWidth; at += hn::Lanes(d)) {
      uint8_t bits[8] = {};
      hn::StoreMaskBits(d, Overlapping(d, bounds_, lanes, at), bits);
      for (uint32_t left = bits[0] | uint32_t{bits[1]} << 8; left != 0; left &= left - 1) {
        const uint32_t child =
            static_cast<uint32_t>(at) + static_cast<uint32_t>(std::countr_zero(left));
        if (child >= first) CollectBelow(level - 1, child);
      }
    }
  }

  void CollectLeaves(size_t base) {
    if (near_count_ + kWidth > kNearRoom) TestNear();
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const BoxLanes leaves = AsLanes(levels_[0]);
    const size_t before = near_count_;
    checks_ += kWidth;
    for (size_t at = base; at < base + kWidth; at += hn::Lanes(d)) {
      const auto hits = Overlapping(d, bounds_, leaves, at);
      for (size_t axis = 0; axis < 3; ++axis) {
        hn::StoreU(hn::Compress(hn::LoadU(d, leaves.min[axis] + at), hits), d,
                   near_min_[axis] + near_count_);
        hn::StoreU(hn::Compress(hn::LoadU(d, leaves.max[axis] + at), hits), d,
                   near_max_[axis] + near_count_);
      }
      const auto index = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<uint32_t>(at)));
      hn::StoreU(hn::Compress(index, hn::RebindMask(du, hits)), du, near_leaf_ + near_count_);
      near_count_ += hn::CountTrue(d, hits);
    }
    if (base != size_t{block_} * kWidth) FetchLeaves(before, near_count_);
  }

  // In large scenes they are not in the cache.
  void FetchLeaves(size_t begin, size_t end) const {
    constexpr size_t kLine = 64;
    for (size_t k = begin; k < end; ++k) {
      const auto* const block = reinterpret_cast<const char*>(blocks_ + near_leaf_[k]);
      for (size_t at = 0; at < sizeof(LeafBlock); at += kLine) hwy::Prefetch(block + at);
    }
  }

  void TestNear() {
    const Lanes16 d;
    for (size_t lane = 0; lane < kWidth; ++lane) {
      near_min_[0][near_count_ + lane] = std::numeric_limits<float>::infinity();
      near_max_[0][near_count_ + lane] = -std::numeric_limits<float>::infinity();
    }
    const uint32_t end =
        static_cast<uint32_t>(std::min<size_t>(levels_[0].count, (size_t{block_} + 1) * kWidth));
    for (uint32_t leaf = block_ * kWidth; leaf < end; ++leaf) {
      const Aabb bounds = BoxAt(AsLanes(levels_[0]), leaf);
      const size_t count = FindBoxes(bounds, FindLeaves(bounds, leaf));
      for (size_t part = 0; part < kWidth; part += hn::Lanes(d)) TestBoxes(leaf, part, count);
    }
    near_count_ = 0;
    own_leaves_pending_ = false;
  }

  // Those of the near leaves that come later than `leaf` and overlap its bounds; how many.
  size_t FindLeaves(const Aabb& bounds, uint32_t leaf) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const BoxLanes near = {{near_min_[0], near_min_[1], near_min_[2]},
                           {near_max_[0], near_max_[1], near_max_[2]},
                           near_leaf_,
                           near_count_};
    size_t count = 0;
    for (size_t at = 0; at < near_count_; at += hn::Lanes(d)) {
      const auto index = hn::LoadU(du, near_leaf_ + at);
      const auto later = hn::Gt(index, hn::Set(du, leaf));
      const auto hits = hn::And(later, hn::RebindMask(du, Overlapping(d, bounds, near, at)));
      hn::StoreU(hn::Compress(index, hits), du, leaves_ + count);
      count += hn::CountTrue(du, hits);
    }
    checks_ += near_count_;
    return count;
  }

  // The places of boxes in those leaves that overlap the bounds; how many.
  size_t FindBoxes(const Aabb& bounds, size_t leaf_count) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    size_t count = 0;
    for (size_t k = 0; k < leaf_count; ++k) {
      const size_t first = leaves_[k] * kBlockWords;
      const BoxLanes boxes = LanesOf(blocks_[leaves_[k]]);
      for (size_t at = 0; at < kWidth; at += hn::Lanes(d)) {
        const auto hits = hn::RebindMask(du, Overlapping(d, bounds, boxes, at));
        const auto place = hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<uint32_t>(first + at)));
        hn::StoreU(hn::Compress(place, hits), du, found_ + count);
        count += hn::CountTrue(du, hits);
      }
    }
    checks_ += leaf_count * kWidth;
    return count;
  }

  // A register of the leaf's boxes against one another and the boxes found.
  void TestBoxes(uint32_t leaf, size_t part, size_t found_count) {
    const Lanes16 d;
    const BoxLanes own = LanesOf(blocks_[leaf]);
    const auto min0 = hn::LoadU(d, own.min[0] + part);
    const auto min1 = hn::LoadU(d, own.min[1] + part);
    const auto min2 = hn::LoadU(d, own.min[2] + part);
    const auto max0 = hn::LoadU(d, own.max[0] + part);
    const auto max1 = hn::LoadU(d, own.max[1] + part);
    const auto max2 = hn::LoadU(d, own.max[2] + part);
    size_t count = 0;
    if (own_leaves_pending_) {
      const auto first = static_cast<uint32_t>(leaf * kBlockWords);
      for (uint32_t lane = 0; lane < kWidth; ++lane) {
        const auto hits = Both(LanesAfter(d, lane, part),
                               HeldHits(d, min0, min1, min2, max0, max1, max2, first + lane));
        count = Note(d, hits, first + lane, count);
      }
      checks_ += kWidth * hn::Lanes(d);
    }
    for (size_t k = 0; k < found_count; ++k) {
      const uint32_t place = found_[k];
      const auto hits = HeldHits(d, min0, min1, min2, max0, max1, max2, place);
      count = Note(d, hits, place, count);
    }
    checks_ += found_count * hn::Lanes(d);
    Emit(own.id + part, count);
  }

  // One box against those held.
  template <class D, class V>
  HWY_INLINE hn::Mask<D> HeldHits(D d, V min0, V min1, V min2, V max0, V max1, V max2,
                                  uint32_t place) const {
    const float* const min = blocks_[0].min[0] + place;
    const float* const max = blocks_[0].max[0] + place;
    const auto ends =
        hn::And(hn::And(hn::Le(min0, hn::Set(d, max[0])), hn::Le(min1, hn::Set(d, max[kWidth]))),
                hn::Le(min2, hn::Set(d, max[2 * kWidth])));
    const auto begins =
        hn::And(hn::And(hn::Ge(max0, hn::Set(d, min[0])), hn::Ge(max1, hn::Set(d, min[kWidth]))),
                hn::Ge(max2, hn::Set(d, min[2 * kWidth])));
    return hn::And(ends, begins);
  }

  static HWY_INLINE BoxLanes LanesOf(const LeafBlock& block) {
    return {{block.min[0], block.min[1], block.min[2]},
            {block.max[0], block.max[1], block.max[2]},
            block.id,
            kWidth};
  }

  // Notes a test that hit, without a branch: more than a third of them do.
  template <class D>
  HWY_INLINE size_t Note(D d, hn::Mask<D> hits, uint32_t place, size_t count) {
    hn::StoreMaskBits(d, hits, hit_lanes_ + count * kMaskBytes);
    hit_place_[count] = place;
    return count + (hn::AllFalse(d, hits) ? 0 : 1);
  }

  // The pairs of `ids` with the boxes noted.
  void Emit(const uint32_t* ids, size_t count) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const auto own = hn::LoadU(du, ids);
    for (size_t k = 0; k < count; ++k) {
      const auto hits = hn::RebindMask(du, hn::LoadMaskBits(d, hit_lanes_ + k * kMaskBytes));
      const auto others = hn::Compress(own, hits);
      const auto self = hn::Set(du, blocks_[0].id[hit_place_[k]]);
      const size_t hit_count = hn::CountTrue(du, hits);
      StorePairs(du, hn::Min(self, others), hn::Max(self, others), hit_count, cursor_.Room(kWidth));
      cursor_.Advance(hit_count);
    }
  }

  // The first `count` pairs, and up to a register more.
  template <class D, class V>
  static HWY_INLINE void StorePairs([[maybe_unused]] D d, V first, V second, size_t count,
                                    OverlapPair* out) {
#if HWY_TARGET == HWY_SCALAR
    (void)count;
    hn::StoreInterleaved2(first, second, d, &out->a);
#else
    // As words of 64 bits: seldom more than half the lanes have a pair.
    const hn::Repartition<uint64_t, D> wide;
    const hn::Half<D> half;
    const auto low = hn::PromoteTo(wide, hn::LowerHalf(half, first));
    const auto high = hn::PromoteTo(wide, hn::LowerHalf(half, second));
    auto* const words = reinterpret_cast<uint64_t*>(out);
    hn::StoreU(hn::Or(low, hn::ShiftLeft<32>(high)), wide, words);
    if (HWY_LIKELY(count <= hn::Lanes(wide))) return;
    const auto upper_low = hn::PromoteTo(wide, hn::UpperHalf(half, first));
    const auto upper_high = hn::PromoteTo(wide, hn::UpperHalf(half, second));
    hn::StoreU(hn::Or(upper_low, hn::ShiftLeft<32>(upper_high)), wide, words + hn::Lanes(wide));
#endif
  }

  const LeafBlock* const blocks_;
  const LeafTree::Level* levels_;
  const size_t level_count_;
  PairCursor cursor_;
  uint32_t block_ = 0;
  Aabb bounds_{};
  size_t near_count_ = 0;
  bool own_leaves_pending_ = false;
  uint64_t checks_ = 0;
  // Registers are stored whole: up to one more than what counts.
  alignas(64) float near_min_[3][kNearRoom + kWidth];
  alignas(64) float near_max_[3][kNearRoom + kWidth];
  alignas(64) uint32_t near_leaf_[kNearRoom + kWidth];
  alignas(64) uint32_t leaves_[kNearRoom + kWidth];
  alignas(64) uint32_t found_[kFoundRoom + kWidth];
  alignas(64) uint32_t hit_place_[kFoundRoom + 2 * kWidth];
  alignas(64) uint8_t hit_lanes_[kMaskBytes * (kFoundRoom + 2 * kWidth)];
};

uint64_t LeafPairs(const LeafBlock* leaves, const LeafTree::Level* levels, size_t level_count,
                   size_t begin, size_t end, PairBuffer& out) {
  BlockSearch search(leaves, levels, level_count, out);
  for (size_t block = begin; block < end; ++block) search.Run(static_cast<uint32_t>(block));
  return search.Finish();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(LeafPairs);

uint64_t FindLeafPairs(const LeafBlock* leaves, const LeafTree::Level* levels, size_t level_count,
                       size_t begin, size_t end, PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(LeafPairs)(leaves, levels, level_count, begin, end, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
