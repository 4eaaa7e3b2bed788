// A tree over some of a table's boxes, the members, kept between changes: a LeafTree in a KdOrder.
//
// A member keeps its slot in the order until the next sort. Removed members leave holes, and new
// ones are sorted among themselves behind the others, so that the leaves stay small for queries.
// Update refits the tree. It sorts all members anew when the new ones are more than 1/128, when a
// quarter of the slots are holes, when more than an eighth of the leaves have grown to twice their
// size, or when searches have lost more checks to the old order than a new one costs.
//
// Thread safety: const calls may run at the same time, but not beside others. Owns its memory.
// Units: the boxes'. Cost: Add and Remove O(1) amortized, Remove without an allocation; Update
// O(n), with a new order O(n log n). Memory: 4 bytes per slot, and 30 more from the first Update
// on. Errors: std::bad_alloc from EnsureRoomFor, which then changes nothing, and from Update, which
// must then be called again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/rebuild_debt.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

class BoxTree {
 public:
  // Must be called before Add, which then does not allocate for so many members.
  void EnsureRoomFor(size_t new_members);
  // Adds box `id`. `slots` is indexed by id, here and in Update: the tree writes the slots of its
  // members there. REQUIRES: it is no member.
  void Add(uint32_t id, std::span<uint32_t> slots);
  // REQUIRES: `slot` is the slot of a member.
  void Remove(uint32_t slot);
  size_t count() const { return count_; }

  // Takes the members' boxes of `boxes`, which is indexed by id. Invalid ones are never found.
  void Update(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);

  const LeafTree::View& view() const { return tree_.view(); }
  const LeafTree& leaves() const { return tree_; }

  // Reports the AABB checks that a search with all boxes has made; at most once per Update.
  void NoteSearch(uint64_t checks) { debt_.AddSearch(checks); }

  // The fields of a snapshot (snapshot.h). If Update was called after the latest change, Refit must
  // follow.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.order_);
    archive.Value(self.count_);
    archive.Value(self.first_new_);
    archive.Value(self.any_new_);
    archive.Array(self.sorted_extents_);
    archive.Value(self.debt_);
  }
  void Refit(std::span<const Aabb> boxes) { tree_.Refit(boxes, order_, nullptr); }

  size_t native_bytes() const {
    return order_.capacity() * sizeof(uint32_t) + tree_.native_bytes() +
           sorted_extents_.capacity() * sizeof(float);
  }

 private:
  bool HasManyHoles() const { return order_.size() - count_ > order_.size() / 4 + 32; }
  bool SortIsDue() const;
  bool HasGrown() const;
  float ExtentOf(size_t leaf) const;
  void SortMembers(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  void SortNewMembers(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  void CloseHoles(size_t begin);
  void NumberSlots(size_t begin, std::span<uint32_t> slots) const;

  HookedVector<uint32_t> order_;  // the members' ids by slot, KdOrder::kHole in holes
  size_t count_ = 0;              // the number of members
  size_t first_new_ = 0;          // the slot from which on members were added since the latest sort
  bool any_new_ = false;          // whether some of those are not sorted among themselves yet
  LeafTree tree_;
  HookedVector<float> sorted_extents_;  // the leaves' extents after the latest sort
  RebuildDebt debt_;                    // the debt of the order
};

}  // namespace sweepstake
