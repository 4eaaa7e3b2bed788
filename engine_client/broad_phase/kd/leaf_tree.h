// An implicit tree whose leaves hold sixteen boxes each, in a given order. Each node has sixteen
// consecutive children, so that the tree needs no pointers.
//
// How well the tree prunes depends on the order alone (kd_order.h). A leaf is contiguous in memory,
// so that a search in a large scene can prefetch it. The tree has two uses. KDTree finds the pairs
// within one tree (FindPairs). ProxySet walks over trees and joins two of them
// (proxies/tree_walk.h).
//
// Not thread-safe; const calls may run at the same time. Owns its memory. Cost: Refit O(slots);
// RefitBlocks O(slots of the blocks + blocks · levels); FindPairs O(leaves · log leaves +
// candidates + pairs). Memory: 30 bytes per slot.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Sixteen boxes. A slot without a valid box holds a sentinel (soa_boxes.h).
struct LeafBlock {
  static constexpr size_t kWidth = 16;
  // The distance between the first boxes of consecutive leaves, in floats.
  static constexpr size_t kStride = 7 * kWidth;

  float min[3][kWidth];
  float max[3][kWidth];
  uint32_t id[kWidth];
};
static_assert(sizeof(LeafBlock) == LeafBlock::kStride * sizeof(float));

inline BoxLanes LanesOf(const LeafBlock& leaf) {
  return {{leaf.min[0], leaf.min[1], leaf.min[2]},
          {leaf.max[0], leaf.max[1], leaf.max[2]},
          leaf.id,
          LeafBlock::kWidth};
}

class LeafTree {
 public:
  static constexpr size_t kWidth = LeafBlock::kWidth;
  static constexpr uint32_t kWidthBits = 4;
  // The number of slots of a block. A block consists of 16 leaves and is the unit of a search.
  static constexpr size_t kBlockSlots = kWidth * kWidth;
  // Eight levels are enough for 16^8 = 2^32 slots.
  static constexpr size_t kMaxLevels = 8;

  // The data that a search reads; valid until the next Refit. Level 0 holds the boxes: box k of
  // leaf j is at j * LeafBlock::kStride + k. Level 1 holds the bounds of the leaves. Node k of each
  // higher level bounds the nodes [16 k, 16 k + 16) of the level below. The level `top` has at most
  // 16 nodes; `top` is 0 if there are no boxes. Sentinels follow the last node of each level.
  struct View {
    const LeafBlock* leaves = nullptr;
    std::array<BoxLanes, kMaxLevels + 1> levels{};
    size_t top = 0;
  };

  // Makes room for `slot_count` slots; the content is lost.
  void Reserve(size_t slot_count) { Reserve(slot_count, slot_count); }
  // Stores boxes[order[k]] with id order[k] in slot k. Stores a sentinel if that box is invalid
  // (aabb.h) or order[k] is not an index of `boxes`. Polls `stop`, which may be null; after a stop
  // the tree is undefined. Reserves room for `spare_slots` more slots.
  void Refit(std::span<const Aabb> boxes, std::span<const uint32_t> order, Executor* executor,
             StopRequest* stop = nullptr, size_t spare_slots = 0);
  // Reads the boxes of the blocks with the numbers in `blocks` again, and computes the bounds of
  // these blocks and of the nodes above them. All other blocks stay unchanged. `order` may have
  // more entries than at the latest Refit; if they exceed the spare slots, the whole tree moves to
  // a larger allocation. REQUIRES: `blocks` is ascending and contains every block that is new since
  // then.
  void RefitBlocks(std::span<const Aabb> boxes, std::span<const uint32_t> order,
                   std::span<const uint32_t> blocks);

  // Sets the id of the box in this slot. Does nothing if the tree does not have the slot yet.
  void SetId(size_t slot, uint32_t id) {
    if (slot < leaf_count_ * kWidth) leaves_[slot / kWidth].id[slot % kWidth] = id;
  }

  const View& view() const { return view_; }
  std::span<const LeafBlock> leaves() const { return {leaves_.data(), leaf_count_}; }
  // Returns the number of blocks.
  size_t block_count() const { return (leaf_count_ + kWidth - 1) / kWidth; }

  // Appends the overlapping pairs whose first box, in the order of the tree, is in the blocks
  // [begin, end). Returns the AABB checks. `stop` may be null. Any thread. (kd_search.cc)
  uint64_t FindPairs(size_t begin, size_t end, PairBuffer& out, StopRequest* stop = nullptr) const;

  size_t native_bytes() const { return leaves_.capacity_bytes() + bounds_.capacity_bytes(); }

 private:
  void Reserve(size_t slot_count, size_t capacity);
  void LayOut(size_t slot_count, size_t capacity);
  void SetCounts(size_t slot_count);
  void Grow(size_t slot_count);
  void BoundFrom(size_t level, size_t begin, size_t end);
  void GatherLeaves(std::span<const Aabb> boxes, std::span<const uint32_t> order, size_t begin,
                    size_t end);

  AlignedBuffer<LeafBlock> leaves_;
  size_t leaf_count_ = 0;
  // The columns of all levels above the boxes, from the leaves' bounds upwards.
  AlignedBuffer<float> bounds_;
  std::array<float*, kMaxLevels + 1> first_column_{};  // the first column of each level
  std::array<size_t, kMaxLevels + 1> stride_{};        // the length of each column of a level
  size_t capacity_ = 0;                                // room for this number of slots
  // The number of levels for capacity_ slots, at least `top`.
  size_t level_count_ = 0;
  View view_;
};

}  // namespace sweepstake
