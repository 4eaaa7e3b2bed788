// The search of a block of leaves among other leaves, for every target of Highway. KDTree finds its
// own pairs with it (kd_search.cc), ProxySet the pairs of two trees (proxies/tree_join.cc). Include
// after hwy/foreach_target.h.
//
// The search has four stages, each a loop over a list that stays in the cache:
//   1. The caller descends a tree with the bounds of the block, once for its 16 leaves, and adds
//      the leaves that overlap them to the near list.
//   2. Each leaf of the block is tested against the near list.
//   3. The boxes of the leaves found are tested against the bounds of the leaf.
//   4. The boxes found are tested against the 16 boxes of the leaf, a register at a time, and
//      the hits are written as pairs.
// Descending for every leaf alone would take longer, since each level has to wait for the result of
// the one above it.
#if defined(SWEEPSTAKE_LEAF_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_LEAF_SEARCH_INL_H_
#undef SWEEPSTAKE_LEAF_SEARCH_INL_H_
#else
#define SWEEPSTAKE_LEAF_SEARCH_INL_H_
#endif

#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// With kWithinOne both trees are the same one, and a pair is found at its earlier leaf; otherwise
// every pair gets `other_bit` in the id of the box of `others`. Keeps its lists on the stack: about
// 60 KiB.
template <bool kWithinOne>
class LeafSearch {
 public:
  static constexpr size_t kWidth = LeafTree::kWidth;

  LeafSearch(const LeafTree::View& own, const LeafTree::View& others, uint32_t other_bit,
             PairBuffer& out)
      : own_(own.leaves),
        own_bounds_(own.levels[1]),
        others_(others.leaves),
        other_bounds_(others.levels[1]),
        other_bit_(other_bit),
        cursor_(out) {}

  // Begins with the leaves [begin, end), at most 16.
  void BeginBlock(size_t begin, size_t end) {
    begin_ = begin;
    end_ = end;
    near_count_ = 0;
    own_pairs_pending_ = true;
  }

  // Adds those of the 16 leaves of `others` from `first` on that overlap the bounds of the block.
  void AddNear(const Aabb& bounds, size_t first) {
    if (near_count_ + kWidth > kNearCapacity) TestNear();
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const BoxLanes leaves = other_bounds_;
    const size_t before = near_count_;
    for (size_t at = first; at < first + kWidth; at += hn::Lanes(d)) {
      const auto hits = Hits(d, bounds, leaves, at);
      for (size_t axis = 0; axis < 3; ++axis) {
        hn::StoreU(CompressLanes(hn::LoadU(d, leaves.min[axis] + at), hits), d,
                   near_min_[axis] + near_count_);
        hn::StoreU(CompressLanes(hn::LoadU(d, leaves.max[axis] + at), hits), d,
                   near_max_[axis] + near_count_);
      }
      const auto index = NumbersFrom(du, at);
      hn::StoreU(CompressLanes(index, hn::RebindMask(du, hits)), du, near_leaf_ + near_count_);
      near_count_ += hn::CountTrue(d, hits);
    }
    if (!kWithinOne || first != begin_) Prefetch(before);
  }

  // Tests the leaves of the block against the near list, and empties it. REQUIRES: called at the
  // end of a block.
  void TestNear() {
    const Lanes16 d;
    // A register of sentinels behind the last near leaf.
    for (size_t lane = 0; lane < kWidth; ++lane) {
      near_min_[0][near_count_ + lane] = std::numeric_limits<float>::infinity();
      near_max_[0][near_count_ + lane] = -std::numeric_limits<float>::infinity();
    }
    for (size_t leaf = begin_; leaf < end_; ++leaf) {
      const Aabb bounds = BoxAt(own_bounds_, leaf);
      const size_t count = FindBoxes(bounds, FindLeaves(bounds, leaf));
      for (size_t part = 0; part < kWidth; part += hn::Lanes(d)) TestBoxes(leaf, part, count);
    }
    near_count_ = 0;
    own_pairs_pending_ = false;
  }

  void AddChecks(uint64_t checks) { checks_ += checks; }

  // Hands all pairs to the buffer and returns the AABB checks.
  uint64_t Finish() {
    cursor_.Flush();
    return checks_;
  }

 private:
  // The number of near leaves that are tested together.
  static constexpr size_t kNearCapacity = 256;
  // There is room for all boxes of the near leaves.
  static constexpr size_t kFoundCapacity = kNearCapacity * kWidth;
  // A stored mask of up to 16 lanes.
  static constexpr size_t kMaskBytes = 2;

  // Prefetches the leaves found, which in large scenes are not in the cache.
  void Prefetch(size_t begin) const {
    constexpr size_t kCacheLine = 64;
    for (size_t k = begin; k < near_count_; ++k) {
      const auto* const leaf = reinterpret_cast<const char*>(others_ + near_leaf_[k]);
      for (size_t at = 0; at < sizeof(LeafBlock); at += kCacheLine) hwy::Prefetch(leaf + at);
    }
  }

  // Stage 2: lists the near leaves that overlap the bounds; within one tree only the later ones.
  size_t FindLeaves(const Aabb& bounds, size_t leaf) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const BoxLanes near = {{near_min_[0], near_min_[1], near_min_[2]},
                           {near_max_[0], near_max_[1], near_max_[2]},
                           near_leaf_,
                           near_count_};
    size_t count = 0;
    for (size_t at = 0; at < near_count_; at += hn::Lanes(d)) {
      const auto index = hn::LoadU(du, near_leaf_ + at);
      auto hits = hn::RebindMask(du, Hits(d, bounds, near, at));
      if constexpr (kWithinOne) {
        hits = hn::And(hn::Gt(index, hn::Set(du, static_cast<uint32_t>(leaf))), hits);
      }
      hn::StoreU(CompressLanes(index, hits), du, leaves_ + count);
      count += hn::CountTrue(du, hits);
    }
    checks_ += near_count_;
    return count;
  }

  // Stage 3: lists the boxes of those leaves that overlap the bounds, as places in the leaves.
  size_t FindBoxes(const Aabb& bounds, size_t leaf_count) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    size_t count = 0;
    for (size_t k = 0; k < leaf_count; ++k) {
      const size_t first = leaves_[k] * LeafBlock::kStride;
      const BoxLanes boxes = LanesOf(others_[leaves_[k]]);
      for (size_t at = 0; at < kWidth; at += hn::Lanes(d)) {
        const auto hits = hn::RebindMask(du, Hits(d, bounds, boxes, at));
        const auto place = NumbersFrom(du, first + at);
        hn::StoreU(CompressLanes(place, hits), du, found_ + count);
        count += hn::CountTrue(du, hits);
      }
    }
    checks_ += leaf_count * kWidth;
    return count;
  }

  // Stage 4: a register of the leaf's boxes against one another and against the boxes found.
  void TestBoxes(size_t leaf, size_t part, size_t found_count) {
    const Lanes16 d;
    const BoxLanes own = LanesOf(own_[leaf]);
    const auto min0 = hn::LoadU(d, own.min[0] + part);
    const auto min1 = hn::LoadU(d, own.min[1] + part);
    const auto min2 = hn::LoadU(d, own.min[2] + part);
    const auto max0 = hn::LoadU(d, own.max[0] + part);
    const auto max1 = hn::LoadU(d, own.max[1] + part);
    const auto max2 = hn::LoadU(d, own.max[2] + part);
    size_t count = 0;
    if (kWithinOne && own_pairs_pending_) {
      const auto first = static_cast<uint32_t>(leaf * LeafBlock::kStride);
      for (uint32_t lane = 0; lane < kWidth; ++lane) {
        const auto hits = Both(LanesAfter(d, lane, part),
                               HeldHits(d, min0, min1, min2, max0, max1, max2, first + lane));
        count = NoteHits(d, hits, first + lane, count);
      }
      checks_ += kWidth * hn::Lanes(d);
    }
    for (size_t k = 0; k < found_count; ++k) {
      const uint32_t place = found_[k];
      const auto hits = HeldHits(d, min0, min1, min2, max0, max1, max2, place);
      count = NoteHits(d, hits, place, count);
    }
    checks_ += found_count * hn::Lanes(d);
    WritePairs(own.id + part, count);
  }

  // Returns which of the register's boxes overlap the box at `place`.
  template <class D, class V>
  HWY_INLINE hn::Mask<D> HeldHits(D d, V min0, V min1, V min2, V max0, V max1, V max2,
                                  uint32_t place) const {
    return HWY_NAMESPACE::HeldHits<kWidth>(d, min0, min1, min2, max0, max1, max2,
                                           others_[0].min[0] + place, others_[0].max[0] + place);
  }

  // Returns the lanes of indices above `index`, where lane 0 is index `at`.
  template <class D>
  static HWY_INLINE hn::Mask<D> LanesAfter(D d, uint32_t index, size_t at) {
    const hn::RebindToUnsigned<D> du;
    const auto lane = NumbersFrom(du, at);
    return hn::RebindMask(d, hn::Gt(lane, hn::Set(du, index)));
  }

  // Keeps the note of a test if it has hits. There is no branch, since about half of the tests
  // have; pairs are written apart from the tests because writing them takes longest.
  template <class D>
  HWY_INLINE size_t NoteHits(D d, hn::Mask<D> hits, uint32_t place, size_t count) {
    hn::StoreMaskBits(d, hits, hit_lanes_ + count * kMaskBytes);
    hit_place_[count] = place;
    return count + (hn::AllFalse(d, hits) ? 0 : 1);
  }

  // Writes the pairs of `ids` with the boxes noted.
  void WritePairs(const uint32_t* ids, size_t count) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    const auto own = hn::LoadU(du, ids);
    for (size_t k = 0; k < count; ++k) {
      const auto hits = hn::RebindMask(du, hn::LoadMaskBits(d, hit_lanes_ + k * kMaskBytes));
      const auto partners = CompressLanes(own, hits);
      const uint32_t id = others_[0].id[hit_place_[k]];
      const auto self = hn::Set(du, kWithinOne ? id : other_bit_ | id);
      const size_t hit_count = hn::CountTrue(du, hits);
      StorePairs(du, hn::Min(self, partners), hn::Max(self, partners), hit_count,
                 cursor_.Room(kWidth));
      cursor_.Advance(hit_count);
    }
  }

  // Stores the first `count` pairs, and up to a register more.
  template <class D, class V>
  static HWY_INLINE void StorePairs([[maybe_unused]] D d, V first, V second, size_t count,
                                    OverlapPair* out) {
#if HWY_TARGET == HWY_SCALAR
    (void)count;
    hn::StoreInterleaved2(first, second, d, &out->a);
#else
    // Pairs are stored as words of 64 bits. The second half is stored only if it has a pair, which
    // is rare.
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

  const LeafBlock* const own_;
  const BoxLanes own_bounds_;
  const LeafBlock* const others_;
  const BoxLanes other_bounds_;
  const uint32_t other_bit_;
  PairCursor cursor_;
  size_t begin_ = 0;
  size_t end_ = 0;
  size_t near_count_ = 0;
  bool own_pairs_pending_ = false;
  uint64_t checks_ = 0;
  // Each list has room for a whole register behind its last entry.
  alignas(64) float near_min_[3][kNearCapacity + kWidth];
  alignas(64) float near_max_[3][kNearCapacity + kWidth];
  alignas(64) uint32_t near_leaf_[kNearCapacity + kWidth];
  alignas(64) uint32_t leaves_[kNearCapacity + kWidth];
  alignas(64) uint32_t found_[kFoundCapacity + kWidth];
  alignas(64) uint32_t hit_place_[kFoundCapacity + 2 * kWidth];
  alignas(64) uint8_t hit_lanes_[kMaskBytes * (kFoundCapacity + 2 * kWidth)];
};

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
