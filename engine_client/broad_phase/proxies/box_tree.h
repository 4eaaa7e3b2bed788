// A tree over some of the boxes of a ProxyTable, its members. It consists of a LeafTree and an
// order of the members (KdOrder), and is updated when members change.
//
// Blocks of sixteen leaves are the unit of change. A branch is the sixteen blocks below one node.
// Update refits the blocks of members that were removed or whose boxes have changed, and the nodes
// above them. Members that have moved and new members go to the block that grows least, as in an
// R-tree, and that block is sorted again. If a block has no room for them, its branch is sorted
// again, and half of the branch may go to another branch.
//
// Many new members that are close together, such as a tile of the world, get separate branches if
// they come at once. These branches become free again when the tile is removed. Branches are in any
// order. The nodes above them, one for 65,536 slots, therefore prune little after many changes, but
// there are few of them. If more than 1/256 of the members have moved, or any may have moved, the
// whole tree is refitted.
//
// All members are sorted again in any of these cases:
// - More than an eighth of them are new, or more than 1/64 if these are not close together.
// - There are many more slots than members.
// - Insertions since the last sort exceed half the members, or a sixteenth if a sort takes only
//   milliseconds.
// - After a refit of the tree, more than an eighth of the leaves have grown to twice their size.
// - Searches have made more extra checks because of the old order than a new order costs
//   (RebuildDebt).
//
// Thread safety: const calls may run at the same time, but not during other calls. Owns its memory.
// Units: the boxes' units. Cost: Add, Remove and Move O(1) amortized, Remove and Move without an
// allocation. Update O(changes · block · log block) amortized; without a sort of all members at
// worst O(branch) per change. With a refit of the tree O(n), with a new order O(n log n). Memory: 4
// bytes per slot, and 30 more from the first Update on. There are 16 slots for 15 members after a
// sort, room for an eighth more in large trees, and at most four slots per member. A sort, or
// FreeUnused before it, frees the memory of former members. Errors: std::bad_alloc from
// EnsureRoomFor and FreeUnused, which then change nothing, and from Update, which must then be
// called again.
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
  // Reserves memory, so that the next `new_members` calls of Add do not allocate. Must be called
  // before Add.
  void EnsureRoomFor(size_t new_members);
  // Adds box `id`. `slots` is indexed by id, here and in Update; the tree writes the slots of its
  // members to it. REQUIRES: the box is not a member.
  void Add(uint32_t id, std::span<uint32_t> slots);
  // Removes the member in `slot`. REQUIRES, here, in Rename and in Move: `slot` is the slot of a
  // member.
  void Remove(uint32_t slot);
  size_t count() const { return count_; }
  // The member in this slot has got another id.
  void Rename(uint32_t slot, uint32_t id) {
    if ((slot & kMark) != 0) {
      new_[slot & ~kMark] = id;
    } else {
      order_[slot] = id | (order_[slot] & kMark);
      tree_.SetId(slot, id);
    }
  }

  // Must be called when the box of the member in this slot has changed, unless the next Update is
  // called with any_moved.
  void Move(uint32_t slot);

  // Updates the tree to the members' boxes, boxes[id]. With `any_moved`, any box may have changed
  // without a call of Move. Searches never find invalid boxes.
  void Update(std::span<const Aabb> boxes, bool any_moved, KdOrder& splitter,
              std::span<uint32_t> slots);

  const LeafTree::View& view() const { return tree_.view(); }
  const LeafTree& leaves() const { return tree_; }

  // Records the AABB checks of a search with all boxes. These checks decide when the members are
  // sorted again. REQUIRES: at most one call per Update.
  void NoteSearch(uint64_t checks) { debt_.AddSearch(checks); }

  // Passes the fields of a snapshot to `archive` (snapshot.h). After a restore, Refit must be
  // called.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.order_);
    archive.Array(self.new_);
    archive.Array(self.states_);
    archive.Array(self.changed_blocks_);
    archive.Array(self.sorted_extents_);
    archive.Value(self.count_);
    archive.Value(self.new_count_);
    archive.Value(self.moved_count_);
    archive.Value(self.inserted_count_);
    archive.Value(self.is_sorted_);
    archive.Value(self.debt_);
  }
  void Refit(std::span<const Aabb> boxes);

  // Frees the memory of former new members, and that of all former members if the next Update sorts
  // all members. Otherwise a sort frees it. Cost: O(members) if there is much to free. Changes
  // nothing if memory runs out.
  void FreeUnused(std::span<uint32_t> slots);
  size_t native_bytes() const;

 private:
  static constexpr uint32_t kHole = KdOrder::kHole;
  static constexpr size_t kBlock = LeafTree::kBlockSlots;
  static constexpr size_t kBranch = LeafTree::kWidth * kBlock;
  // A sort of many members leaves the last leaf of each block free.
  static constexpr size_t kSortedLeaves = LeafTree::kWidth - 1;
  static constexpr size_t kSorted = kSortedLeaves * LeafTree::kWidth;
  // The highest bit serves as a flag. In the slot of a member it means that the slot is an index of
  // `new_`. In an entry of `order_` it means that the member's box has changed. Ids never reach
  // this bit (ProxyIds::kMaxIds), slots only with 500,000,000 members, some 60 GB.
  static constexpr uint32_t kMark = 0x80000000;

  // The state of a block until the next refit: unchanged, changed or sorted again.
  enum class BlockState : uint8_t { kFresh, kChanged, kSorted };

  static bool IsMoved(uint32_t entry) { return entry != kHole && (entry & kMark) != 0; }
  static size_t SpareSlots(size_t slot_count) {
    return slot_count < 16 * kBranch ? 0 : slot_count / 8;
  }

  // Records the state of a block for the next refit. A later state replaces an earlier one.
  void Mark(size_t block, BlockState state) {
    if (states_[block] == BlockState::kFresh) {
      changed_blocks_.push_back(static_cast<uint32_t>(block));  // has room for every block
    }
    states_[block] = state;
  }
  void ReserveBlocks(size_t block_count);

  // The steps of Update.
  void RefitAll(std::span<const Aabb> boxes);
  void RefitChanged(std::span<const Aabb> boxes);
  void TakeOut(std::span<uint32_t> slots);
  void SortMembers(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  bool IsOversized(size_t capacity) const { return capacity > 4 * (count_ + kBlock); }
  void StartAgain(std::span<uint32_t> slots);
  void JoinMembers();
  void SpreadMembers();
  void NumberSlots(std::span<uint32_t> slots) const;
  bool HasGrown() const;
  float ExtentOf(size_t leaf) const;
  void NoteExtents(size_t begin, size_t end);

  // Insertion of new members into blocks (box_tree_inserts.cc).
  void InsertNew(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  bool InsertRun(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  void InsertEach(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots);
  bool InsertIntoBlocks(std::span<const uint64_t> placed, std::span<const Aabb> boxes,
                        KdOrder& splitter, std::span<uint32_t> slots);
  void SortBranch(size_t branch, std::span<const uint64_t> placed, std::span<const Aabb> boxes,
                  KdOrder& splitter, std::span<uint32_t> slots);
  void AppendMembers(size_t block);
  void WriteBranch(size_t branch, size_t begin, size_t end, std::span<uint32_t> slots);
  void WriteBlock(size_t block, std::span<const uint32_t> ids, std::span<uint32_t> slots);
  bool IsFree(size_t first_slot, size_t slot_count) const;
  size_t FreeBranch(size_t from) const;
  void ReserveSlots(size_t slot_count);

  HookedVector<uint32_t> order_;  // the members' ids by slot; kHole marks a free slot
  HookedVector<uint32_t> new_;    // the ids of members added since the latest Update
  HookedVector<BlockState> states_;
  HookedVector<uint32_t> changed_blocks_;  // the blocks that are not kFresh
  HookedVector<float> sorted_extents_;     // the leaves' extents when they were sorted
  size_t count_ = 0;                       // the number of members
  size_t new_count_ = 0;                   // the number of members in `new_`
  size_t moved_count_ = 0;                 // the number of members marked in `order_`
  size_t inserted_count_ = 0;              // members inserted into blocks since the latest sort
  bool is_sorted_ = false;                 // whether the next Update may keep the order
  LeafTree tree_;
  RebuildDebt debt_;  // extra checks since the latest sort

  // Working memory of Update, without content between calls.
  HookedVector<uint64_t> placed_;  // new members: block in the upper half, id in the lower
  HookedVector<uint32_t> ids_;
};

}  // namespace sweepstake
