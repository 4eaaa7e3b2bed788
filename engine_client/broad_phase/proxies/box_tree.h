// A tree over one set of boxes that answers queries between changes: a kd order (kd_order.h), kept
// while it serves, and bounds of 16 slots each (leaf_tree.h).
//
// Thread safety: const calls may run side by side; Update stands alone. Owns its memory. Units: the
// boxes'. Cost: Update O(n), some 2 ns per box, and 12 ns more where the order is made anew: when
// more than an eighth of the leaves have grown to twice what they were then, or searches have lost
// more to an old order than a new one takes. A query descends the levels a register of nodes at a
// time. Memory: 100 bytes per box. Errors: std::bad_alloc from Update, which must then be called
// again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "engine_client/broad_phase/proxies/tree_walk.h"

namespace sweepstake {

class BoxTree {
 public:
  // Takes these boxes; box k has id k. Boxes that do not take part are never found.
  void Update(std::span<const Aabb> boxes);

  const TreeView& view() const { return view_; }

  // Says how many AABB checks one of like searches with all boxes took, once per Update or less:
  // what they take more than the least since the order was made counts as lost.
  void NoteSearch(uint64_t checks);

  size_t native_bytes() const {
    return splitter_.native_bytes() + order_.capacity_bytes() + sorted_.native_bytes() +
           leaves_.native_bytes() + sorted_extents_.capacity_bytes();
  }

 private:
  void Extend(size_t count);
  void Sort(std::span<const Aabb> boxes);
  void Refit(std::span<const Aabb> boxes);
  bool IsWorn() const;
  bool HasGrown() const;
  float ExtentOf(size_t leaf) const;

  KdOrder splitter_;
  AlignedBuffer<uint32_t> order_;
  size_t ordered_count_ = 0;  // of order_
  SoaBoxes sorted_;
  LeafTree leaves_;
  AlignedBuffer<float> sorted_extents_;  // of each leaf when the order was made
  size_t sorted_leaf_count_ = 0;
  uint64_t fewest_checks_ = 0;  // of a search since then
  uint64_t lost_checks_ = 0;
  TreeView view_;
};

}  // namespace sweepstake
