// An implicit tree over boxes in a given order: leaves of 16 consecutive slots, nodes of 16
// consecutive children.
//
// How good it is rests on the order (kd_order.h). Level 0 holds the bounds of the leaves, each
// further level those of 16 below; there are no pointers. Pairs are sought leaf by leaf: the bounds
// of a leaf go down the levels, a register of nodes at a time, to the later leaves they overlap; of
// those, the boxes that overlap the bounds are collected; and each of them is tested against the
// leaf's 16 boxes at once.
//
// Not thread-safe. Owns its memory. Cost: Refit O(n); FindPairs O(leaves · log n + candidates).
// Memory: 7 bytes per box of bounds and queues.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

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

  // Takes the bounds of these boxes. REQUIRES: the lanes stay as they are until the last FindPairs
  // on them.
  void Refit(const BoxLanes& lanes);

  // Appends every overlapping pair; returns the AABB checks. REQUIRES: `lanes` as in the latest
  // Refit.
  uint64_t FindPairs(const BoxLanes& lanes, PairBuffer& out);

  size_t level_count() const { return level_count_; }
  const Level& level(size_t index) const { return levels_[index]; }
  size_t native_bytes() const {
    return bounds_.capacity_bytes() + queues_[0].capacity_bytes() + queues_[1].capacity_bytes();
  }

 private:
  void LayOutLevels(size_t box_count);

  AlignedBuffer<float> bounds_;
  std::array<Level, kMaxLevels> levels_{};
  size_t level_count_ = 0;
  // Nodes found at one level, and what they lead to at the next.
  AlignedBuffer<uint32_t> queues_[2];
};

}  // namespace sweepstake
