// An implicit tree over boxes in a given order: leaves of 16 consecutive slots, nodes of 16
// consecutive children.
//
// How good it is rests on the order (kd_order.h). Level 0 holds the bounds of the leaves, each
// further level those of 16 below; there are no pointers. How pairs are sought: leaf_pairs.h.
//
// Not thread-safe, but for the search in parts. Owns its memory. Cost: Refit O(n), 0.6 ns per box;
// FindPairs O(blocks · log n + candidates + pairs), 9 ns per box of suite-b at 10,000, 14 at
// 1,000,000. Memory: 2 bytes per box.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

struct LeafBlock;  // leaf_boxes.h

class LeafTree {
 public:
  static constexpr size_t kWidth = 16;
  static constexpr int kWidthBits = 4;
  // 16^8 = 2^32 slots.
  static constexpr size_t kMaxLevels = 8;

  // Bounds of all nodes at one level; `count` nodes, behind them sentinels as in SoaBoxes.
  struct Level {
    float* min[3];
    float* max[3];
    size_t count;
  };

  // Takes the bounds of these boxes.
  void Refit(const BoxLanes& lanes);
  // The same where the bounds of the leaves come from elsewhere (LeafBoxes::GatherLeaves): LayOut,
  // the bounds of all leaves to level(0), RefitNodes.
  void LayOut(size_t box_count);
  void RefitNodes();

  // Appends every overlapping pair of which the earlier box is in the blocks [begin, end) of 256
  // boxes; returns the AABB checks. REQUIRES: the tree has the bounds of these leaves. Any thread.
  uint64_t FindPairs(const LeafBlock* leaves, size_t begin, size_t end, PairBuffer& out) const;
  size_t block_count() const { return (leaf_count() + kWidth - 1) / kWidth; }

  size_t leaf_count() const { return level_count_ == 0 ? 0 : levels_[0].count; }
  size_t level_count() const { return level_count_; }
  const Level& level(size_t index) const { return levels_[index]; }
  size_t native_bytes() const { return bounds_.capacity_bytes(); }

 private:
  AlignedBuffer<float> bounds_;
  std::array<Level, kMaxLevels> levels_{};
  size_t level_count_ = 0;
};

}  // namespace sweepstake
