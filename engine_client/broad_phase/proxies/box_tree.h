// A tree over the boxes of one kind of proxies, kept between changes: a LeafTree in a KdOrder.
//
// Update refits the tree. It makes a new order when more than an eighth of the leaves have grown to
// twice their size, or when searches have lost more checks to the old order than a new one costs.
//
// Thread safety: const calls may run at the same time, but not beside Update. Owns its memory.
// Units: the boxes'. Cost: Update O(n), with a new order O(n log n). Memory: 70 bytes per box.
// Errors: std::bad_alloc from Update, which must then be called again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/rebuild_debt.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

class BoxTree {
 public:
  // Takes these boxes; box k has id k. Invalid boxes are never found.
  void Update(std::span<const Aabb> boxes);

  const LeafTree::View& view() const { return tree_.view(); }

  // Reports the AABB checks that a search with all boxes has made; at most once per Update.
  void NoteSearch(uint64_t checks) { debt_.AddSearch(checks); }

  size_t native_bytes() const {
    return splitter_.native_bytes() + order_.capacity_bytes() + tree_.native_bytes() +
           sorted_extents_.capacity_bytes();
  }

 private:
  void Resize(size_t count);
  void Sort(std::span<const Aabb> boxes);
  void Refit(std::span<const Aabb> boxes) { tree_.Refit(boxes, {order_.data(), count_}, nullptr); }
  bool SortIsDue() const;
  bool HasGrown() const;
  float ExtentOf(size_t leaf) const;

  KdOrder splitter_;
  AlignedBuffer<uint32_t> order_;
  size_t count_ = 0;  // the number of boxes
  LeafTree tree_;
  AlignedBuffer<float> sorted_extents_;  // the leaves' extents after the latest sort
  size_t sorted_leaf_count_ = 0;
  RebuildDebt debt_;  // the debt of the order
};

}  // namespace sweepstake
