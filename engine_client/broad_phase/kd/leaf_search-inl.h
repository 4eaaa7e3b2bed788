// The search of a block of leaves among other leaves, for every target of Highway. KDTree uses it
// to find its own pairs (kd_search.cc), ProxySet to find the pairs of two trees
// (proxies/tree_join.cc). Include after hwy/foreach_target.h.
//
// The search has four stages, each a loop over a list that stays in the cache:
//   1. The caller descends a tree with the bounds of the block, once for its 16 leaves, and adds
//      the leaves that overlap them to the near list.
//   2. Each leaf of the block is tested against the near list.
//   3. The boxes of the leaves found are tested against the bounds of the leaf.
//   4. The boxes found are tested against the 16 boxes of the leaf, a register at a time, and
//      the hits are written as pairs.
// A separate descent for every leaf would take longer, since each level has to wait for the result
// of the level above.
#if defined(SWEEPSTAKE_LEAF_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_LEAF_SEARCH_INL_H_
#undef SWEEPSTAKE_LEAF_SEARCH_INL_H_
#else
#define SWEEPSTAKE_LEAF_SEARCH_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/common/stop_poll.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Finds the pairs of the boxes of `own` with the boxes of `others`. With kWithinOne both are one
// tree, and a pair is found at its earlier leaf. Otherwise the pairs hold ids of `others` with
// `other_bit` set. The lists are on the stack: about 28 KiB, or 51 KiB with 128-bit registers.
template <bool kWithinOne>
class LeafSearch {
 public:
  static constexpr size_t kWidth = LeafTree::kWidth;

  LeafSearch(const LeafTree::View& own, const LeafTree::View& others, uint32_t other_bit,
             PairBuffer& out, StopRequest* stop = nullptr)
      : own_(own.leaves),
        own_bounds_(own.levels[1]),
        others_(others.leaves),
        other_bounds_(others.levels[1]),
        other_bit_(other_bit),
        poll_(stop, out),
        cursor_(out) {}

  // Begins the search of a block, which consists of the leaves [begin, end), at most 16.
  void BeginBlock(size_t begin, size_t end) {
    begin_ = begin;
    end_ = end;
    near_count_ = 0;
    own_pairs_pending_ = true;
  }

  // Tests the 16 leaves of `others` from `first` on. Adds each leaf that overlaps the bounds of the
  // block to the near list.
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
    if (kWithinOne && first == begin_) return;
    for (size_t k = before; k < near_count_; ++k) Prefetch(near_leaf_[k]);
  }

  // Tests the leaves of the block against the near list and empties it. Must be called at the end
  // of each block.
  void TestNear() {
    if (Ends()) near_count_ = 0;
    // Writes a register of sentinels behind the last near leaf.
    for (size_t lane = 0; lane < kWidth; ++lane) {
      near_min_[0][near_count_ + lane] = std::numeric_limits<float>::infinity();
      near_max_[0][near_count_ + lane] = -std::numeric_limits<float>::infinity();
    }
    for (size_t leaf = begin_; leaf < end_; ++leaf) {
      const Aabb bounds = BoxAt(own_bounds_, leaf);
      TestBoxes(leaf, FindBoxes(bounds, FindLeaves(bounds, leaf)));
    }
    near_count_ = 0;
    own_pairs_pending_ = false;
  }

  // Prefetches a leaf of `others`, which in large scenes is not in the cache.
  void Prefetch(size_t leaf) const {
    constexpr size_t kCacheLine = 64;
    const auto* const bytes = reinterpret_cast<const char*>(others_ + leaf);
    for (size_t at = 0; at < sizeof(LeafBlock); at += kCacheLine) hwy::Prefetch(bytes + at);
  }

  // Finds the pairs of one box of `own` with the boxes of a leaf of `others`, without the four
  // stages described at the top of this file.
  void TestBox(const Aabb& box, uint32_t id, size_t leaf) {
    const Lanes16 d;
    const LeafBlock& others = others_[leaf];
    for (size_t at = 0; at < kWidth; at += hn::Lanes(d)) {
      uint32_t hits = BitsOfMask(d, Hits(d, box, LanesOf(others), at));
      for (; hits != 0; hits &= hits - 1) {
        const size_t lane = at + static_cast<size_t>(std::countr_zero(hits));
        cursor_.Append(id, other_bit_ | others.id[lane]);
      }
    }
    checks_ += kWidth;
  }

  void AddChecks(uint64_t checks) { checks_ += checks; }
  // Returns whether the search must end.
  bool Ends() { return poll_.Ends(checks_); }

  // Writes the remaining pairs to the buffer and returns the AABB checks.
  uint64_t Finish() {
    cursor_.Flush();
    return checks_;
  }

 private:
  // The maximum number of leaves in the near list, which are tested together.
  static constexpr size_t kNearCapacity = 256;
  // Room for all boxes of the near leaves.
  static constexpr size_t kFoundCapacity = kNearCapacity * kWidth;
  // The number of found boxes that a leaf is tested against at a time.
  static constexpr size_t kTestedTogether = 512;
  // The number of notes (see Notes) for which room in the pair buffer is reserved at a time.
  static constexpr size_t kNotesPerRoom = 32;

  // A note records that a box of `others` overlaps boxes in a register of the leaf: the place of
  // the box (see PlaceOf), and the lanes that it overlaps, as bits. The extra room is for the
  // leaf's own boxes, and for a note that is written but not counted.
  struct Notes {
    uint32_t place[kTestedTogether + kWidth + 1];
    uint16_t lanes[kTestedTogether + kWidth + 1];
  };

  // Stage 2: lists near leaves that overlap the bounds. With kWithinOne it lists only later leaves.
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

  // Stage 3: lists the places (see PlaceOf) of the boxes in the found leaves that overlap the
  // bounds.
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

  // Stage 4: tests the leaf's boxes against one another and against the boxes found,
  // kTestedTogether at a time.
  void TestBoxes(size_t leaf, size_t found_count) {
    bool with_own = kWithinOne && own_pairs_pending_;
    for (size_t k = 0; with_own || k < found_count; k += kTestedTogether, with_own = false)
      TestSome(leaf, with_own, found_ + k, std::min(kTestedTogether, found_count - k));
  }

#if HWY_MAX_BYTES == 16
  // With 128-bit registers, copying the other box's faces to all lanes costs more than comparing
  // them. The copies are therefore reused for all registers of the leaf.
  void TestSome(size_t leaf, bool with_own, const uint32_t* places, size_t place_count) {
    if (with_own) {
      uint32_t own[kWidth];
      for (size_t lane = 0; lane < kWidth; ++lane) own[lane] = PlaceOf(leaf, lane);
      TestInTurns<true>(own_[leaf], own, kWidth);
    }
    TestInTurns<false>(own_[leaf], places, place_count);
  }

  template <bool kOwn>
  void TestInTurns(const LeafBlock& own, const uint32_t* places, size_t place_count) {
    const Lanes16 d;
    constexpr size_t kRegisters = kWidth / 4;
    const BoxLanes own_boxes = LanesOf(own);
    const BoxLanes boxes = LanesOf(others_[0]);
    Notes notes[kRegisters];
    size_t count[kRegisters] = {};
    for (size_t k = 0; k < place_count; ++k) {
      const Aabb box = BoxAt(boxes, places[k]);
      for (size_t r = 0; r < kRegisters; ++r) {
        const size_t at = r * hn::Lanes(d);
        uint32_t hits = BitsOfMask(d, Hits(d, box, own_boxes, at));
        if constexpr (kOwn) hits &= LanesAfter(k) >> at;
        count[r] = Note(notes[r], hits, places[k], count[r]);
      }
    }
    checks_ += place_count * kWidth;
    for (size_t r = 0; r < kRegisters; ++r)
      WritePairs(own.id + r * hn::Lanes(d), notes[r], count[r]);
  }
#else
  // Keeps the faces of one register of the leaf's boxes loaded.
  void TestSome(size_t leaf, bool with_own, const uint32_t* places, size_t place_count) {
    for (size_t part = 0; part < kWidth; part += hn::Lanes(Lanes16()))
      TestPart(leaf, part, with_own, places, place_count);
  }

  // Not inlined, since the inlined code would keep the faces on the stack instead of in registers.
  HWY_NOINLINE void TestPart(size_t leaf, size_t part, bool with_own, const uint32_t* places,
                             size_t place_count) {
    const Lanes16 d;
    const BoxLanes own = LanesOf(own_[leaf]);
    const auto min0 = hn::LoadU(d, own.min[0] + part);
    const auto min1 = hn::LoadU(d, own.min[1] + part);
    const auto min2 = hn::LoadU(d, own.min[2] + part);
    const auto max0 = hn::LoadU(d, own.max[0] + part);
    const auto max1 = hn::LoadU(d, own.max[1] + part);
    const auto max2 = hn::LoadU(d, own.max[2] + part);
    const LeafBlock& others = others_[0];
    const auto hits_of = [&](uint32_t place) HWY_ATTR {
      return BitsOfMask(d, HeldHits<kWidth>(d, min0, min1, min2, max0, max1, max2,
                                            others.min[0] + place, others.max[0] + place));
    };
    size_t count = 0;
    if (with_own) {
      for (size_t lane = 0; lane < kWidth; ++lane) {
        const uint32_t place = PlaceOf(leaf, lane);
        count = Note(notes_, hits_of(place) & LanesAfter(lane) >> part, place, count);
      }
      checks_ += kWidth * hn::Lanes(d);
    }
    for (size_t k = 0; k < place_count; ++k) {
      const uint32_t place = places[k];
      count = Note(notes_, hits_of(place), place, count);
    }
    checks_ += place_count * hn::Lanes(d);
    WritePairs(own.id + part, notes_, count);
  }

  Notes notes_;
#endif

  static HWY_INLINE uint32_t PlaceOf(size_t leaf, size_t lane) {
    return static_cast<uint32_t>(leaf * LeafBlock::kStride + lane);
  }

  // Returns the lanes after `lane`, as bits. A box is tested only against later boxes of its own
  // leaf, so that each pair within the leaf is found once.
  static HWY_INLINE uint32_t LanesAfter(size_t lane) { return ~1U << lane; }

  // Appends a note if a test has hits. A branch would often be mispredicted, since about half of
  // the tests have hits. Writing pairs takes longest and is therefore left to WritePairs.
  static HWY_INLINE size_t Note(Notes& notes, uint32_t hits, uint32_t place, size_t count) {
    notes.lanes[count] = static_cast<uint16_t>(hits);
    notes.place[count] = place;
    return count + (hits != 0 ? 1 : 0);
  }

  // Writes the pairs that the notes describe. `ids` are the ids of the boxes in the leaf's
  // register.
  void WritePairs(const uint32_t* ids, const Notes& notes, size_t count) {
    const hn::RebindToUnsigned<Lanes16> du;
    const auto own = hn::LoadU(du, ids);
    const uint32_t* const other_ids = others_[0].id;
    for (size_t k = 0; k < count;) {
      OverlapPair* const room = cursor_.Room(kNotesPerRoom * hn::Lanes(du));
      OverlapPair* out = room;
      for (const size_t end = std::min(count, k + kNotesPerRoom); k < end; ++k) {
        const uint32_t hits = notes.lanes[k];
        const auto partners = CompressBits(own, hits);
        const uint32_t id = other_ids[notes.place[k]];
        const auto self = hn::Set(du, kWithinOne ? id : other_bit_ | id);
        const size_t hit_count = hwy::PopCount(hits);
        StorePairs<false>(self, partners, hit_count, out);
        out += hit_count;
      }
      cursor_.Advance(static_cast<size_t>(out - room));
    }
  }

  const LeafBlock* const own_;
  const BoxLanes own_bounds_;
  const LeafBlock* const others_;
  const BoxLanes other_bounds_;
  const uint32_t other_bit_;
  StopPoll poll_;
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
};

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
