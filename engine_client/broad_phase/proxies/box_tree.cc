#include "engine_client/broad_phase/proxies/box_tree.h"

#include <algorithm>
#include <utility>

namespace sweepstake {
namespace {

// The cost of sorting all members, in checks per member.
constexpr uint64_t kChecksPerSort = 20;
// If more than 1 in 8 members is new, sorting all members takes less time than inserting the new
// ones.
constexpr size_t kMembersPerNewOne = 8;
// If a changed block has at most this number of members, all of them are inserted into other
// blocks, so that the block becomes free.
constexpr size_t kMinMembers = 48;
// Sorting up to this number of members takes a few milliseconds, so that small trees may be sorted
// more often.
constexpr size_t kQuicklySorted = 65'536;
// If more than 1 in 256 members has moved, refitting the whole tree takes less time than moving
// them.
constexpr size_t kMembersPerMovedOne = 256;

constexpr size_t RoundUp(size_t count, size_t unit) { return (count + unit - 1) / unit * unit; }

void CloseHoles(HookedVector<uint32_t>& ids) {
  ids.erase(std::remove(ids.begin(), ids.end(), KdOrder::kHole), ids.end());
}

}  // namespace

void BoxTree::EnsureRoomFor(size_t new_members) {
  const size_t needed = new_.size() + new_members;
  if (needed <= new_.capacity()) return;
  new_.reserve(new_.empty() ? needed : std::max(needed, 2 * new_.size()));
}

void BoxTree::Add(uint32_t id, std::span<uint32_t> slots) {
  // Removes the holes that Remove has left in new_. Otherwise new_ would grow without limit if
  // members are added and removed without an Update.
  if (new_.size() - new_count_ > new_.size() / 4 + 32) {
    CloseHoles(new_);
    for (size_t k = 0; k < new_.size(); ++k) slots[new_[k]] = static_cast<uint32_t>(k) | kMark;
  }
  slots[id] = static_cast<uint32_t>(new_.size()) | kMark;
  new_.push_back(id);
  ++new_count_;
  ++count_;
}

void BoxTree::Remove(uint32_t slot) {
  --count_;
  if ((slot & kMark) != 0) {
    new_[slot & ~kMark] = kHole;
    --new_count_;
    return;
  }
  if (IsMoved(order_[slot])) --moved_count_;
  order_[slot] = kHole;
  // The next Update would sort all members anyway, unless others are added before it. If that is
  // settled now, FreeUnused may free the slots without a change of results.
  if (IsOversized(order_.size())) is_sorted_ = false;
  Mark(slot / kBlock, BlockState::kChanged);
}

void BoxTree::Move(uint32_t slot) {
  if ((slot & kMark) != 0 || IsMoved(order_[slot])) return;
  order_[slot] |= kMark;
  ++moved_count_;
  Mark(slot / kBlock, BlockState::kChanged);
}

void BoxTree::Update(std::span<const Aabb> boxes, bool any_moved, KdOrder& splitter,
                     std::span<uint32_t> slots) {
  const bool refits_all =
      any_moved || order_.size() <= kBlock || moved_count_ * kMembersPerMovedOne > count_;
  // Limits the number of slots, since a refit reads all of them. Limits the number of insertions
  // since the latest sort, since each insertion degrades the order.
  const size_t max_slots = (refits_all || count_ <= kQuicklySorted ? 2 : 4) * (count_ + kBlock);
  const size_t max_inserted = count_ / (count_ <= kQuicklySorted ? 16 : 2);
  if (!is_sorted_ || new_count_ * kMembersPerNewOne > count_ || order_.size() > max_slots ||
      inserted_count_ > max_inserted || (new_count_ > 0 && order_.size() <= kBlock)) {
    return SortMembers(boxes, splitter, slots);
  }
  if (refits_all) {
    RefitAll(boxes);
  } else {
    TakeOut(slots);
    RefitChanged(boxes);
  }
  if (new_count_ > 0) InsertNew(boxes, splitter, slots);
  if (count_ == 0) return;
  if (debt_.Exceeds(kChecksPerSort * count_) || (refits_all && HasGrown())) {
    SortMembers(boxes, splitter, slots);
  }
}

void BoxTree::ReserveBlocks(size_t block_count) {
  changed_blocks_.reserve(block_count);
  states_.reserve(block_count);
}

void BoxTree::RefitAll(std::span<const Aabb> boxes) {
  if (moved_count_ > 0) {
    for (uint32_t& entry : order_) {
      if (IsMoved(entry)) entry &= ~kMark;
    }
  }
  moved_count_ = 0;
  for (const uint32_t block : changed_blocks_) states_[block] = BlockState::kFresh;
  changed_blocks_.clear();
  // is_sorted_ is true again once Refit has succeeded. If memory runs out in Refit, the next Update
  // sorts all members.
  is_sorted_ = false;
  Refit(boxes);
  is_sorted_ = true;
}

void BoxTree::RefitChanged(std::span<const Aabb> boxes) {
  if (changed_blocks_.empty()) return;
  sorted_extents_.resize(RoundUp(order_.size(), LeafTree::kWidth) / LeafTree::kWidth);
  std::sort(changed_blocks_.begin(), changed_blocks_.end());
  tree_.RefitBlocks(boxes, order_, changed_blocks_);
  for (const uint32_t block : changed_blocks_) {
    const size_t first = size_t{block} * LeafTree::kWidth;
    if (states_[block] == BlockState::kSorted) {
      NoteExtents(first, std::min(first + LeafTree::kWidth, sorted_extents_.size()));
    }
    states_[block] = BlockState::kFresh;
  }
  changed_blocks_.clear();
}

// Removes moved members from their blocks and adds them again as new members. If a changed block
// has at most kMinMembers members, does the same with all of them.
void BoxTree::TakeOut(std::span<uint32_t> slots) {
  EnsureRoomFor(moved_count_ + changed_blocks_.size() * kMinMembers);
  for (const size_t block : changed_blocks_) {
    const std::span<uint32_t> entries =
        std::span(order_).subspan(block * kBlock, std::min(kBlock, order_.size() - block * kBlock));
    const auto holes = static_cast<size_t>(std::count(entries.begin(), entries.end(), kHole));
    const bool takes_all = entries.size() - holes <= kMinMembers;
    for (size_t k = 0; k < entries.size(); ++k) {
      if (entries[k] == kHole || !(takes_all || IsMoved(entries[k]))) continue;
      const uint32_t id = entries[k] & ~kMark;
      Remove(static_cast<uint32_t>(block * kBlock + k));
      Add(id, slots);
    }
  }
}

void BoxTree::SortMembers(std::span<const Aabb> boxes, KdOrder& splitter,
                          std::span<uint32_t> slots) {
  if (IsOversized(std::max(order_.capacity(), new_.capacity()))) StartAgain(slots);
  const size_t slot_count = count_ <= kBlock ? RoundUp(count_, LeafTree::kWidth)
                                             : RoundUp(count_, kSorted) / kSorted * kBlock;
  (order_.empty() ? new_ : order_).reserve(slot_count + SpareSlots(slot_count));
  ReserveBlocks((slot_count + SpareSlots(slot_count)) / kBlock + 1);
  // is_sorted_ is false until the tree is up to date. If memory runs out before that, the next
  // Update sorts all members.
  is_sorted_ = false;
  if (order_.empty()) std::swap(order_, new_);
  JoinMembers();
  states_.assign(RoundUp(slot_count, kBlock) / kBlock, BlockState::kFresh);
  changed_blocks_.clear();
  NumberSlots(slots);
  if (!order_.empty()) splitter.Sort(boxes, order_, nullptr, kSortedLeaves);
  order_.resize(slot_count, kHole);
  if (count_ > kBlock) SpreadMembers();
  NumberSlots(slots);
  Refit(boxes);
  debt_.Clear();
  sorted_extents_.resize(tree_.leaves().size());
  NoteExtents(0, sorted_extents_.size());
  is_sorted_ = true;
}

// Replaces the tree by one without memory in which all members are new. Their order stays the same,
// so that results do not depend on the memory.
void BoxTree::StartAgain(std::span<uint32_t> slots) {
  BoxTree smaller;
  smaller.EnsureRoomFor(count_);
  for (const HookedVector<uint32_t>* const entries : {&order_, &new_}) {
    for (const uint32_t entry : *entries) {
      if (entry != kHole) smaller.Add(entry & ~kMark, slots);
    }
  }
  *this = std::move(smaller);
}

// Appends the new members to `order_` and removes its holes and marks.
void BoxTree::JoinMembers() {
  CloseHoles(new_);
  CloseHoles(order_);
  order_.insert(order_.end(), new_.begin(), new_.end());
  for (uint32_t& entry : order_) entry &= ~kMark;
  new_.clear();
  new_count_ = moved_count_ = inserted_count_ = 0;
}

void BoxTree::NumberSlots(std::span<uint32_t> slots) const {
  for (size_t slot = 0; slot < order_.size(); ++slot) {
    if (order_[slot] != kHole) slots[order_[slot]] = static_cast<uint32_t>(slot);
  }
}

// Spreads the members over the blocks, kSorted per block. Before the call they fill the first
// slots.
void BoxTree::SpreadMembers() {
  const auto slot = [&](size_t at) { return order_.begin() + static_cast<std::ptrdiff_t>(at); };
  for (size_t block = order_.size() / kBlock; block-- > 0;) {
    const size_t begin = block * kSorted;
    const size_t end = std::min(begin + kSorted, count_);
    const auto last = slot(block * kBlock + end - begin);
    std::copy_backward(slot(begin), slot(end), last);
    std::fill(last, slot((block + 1) * kBlock), kHole);
  }
}

void BoxTree::Refit(std::span<const Aabb> boxes) {
  // Reserves as many blocks as `states_` can grow to, so that Remove and Move do not allocate.
  ReserveBlocks(states_.capacity());
  tree_.Refit(boxes, order_, nullptr, nullptr, SpareSlots(order_.size()));
}

// Returns whether many leaves have grown. It counts leaves, since in a sum of extents one box that
// has moved far away would outweigh all others.
bool BoxTree::HasGrown() const {
  size_t grown = 0;
  for (size_t leaf = 0; leaf < sorted_extents_.size(); ++leaf) {
    if (ExtentOf(leaf) > 2 * sorted_extents_[leaf]) ++grown;
  }
  return grown * 8 > sorted_extents_.size();
}

void BoxTree::NoteExtents(size_t begin, size_t end) {
  for (size_t leaf = begin; leaf < end; ++leaf) sorted_extents_[leaf] = ExtentOf(leaf);
}

// Returns the sum of the leaf's extents over the axes; 0 if the leaf has no valid box.
float BoxTree::ExtentOf(size_t leaf) const {
  const BoxLanes& bounds = view().levels[1];
  float sum = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    sum += std::max(0.0F, bounds.max[axis][leaf] - bounds.min[axis][leaf]);
  }
  return sum;
}

void BoxTree::FreeUnused(std::span<uint32_t> slots) {
  if (!is_sorted_ && IsOversized(order_.capacity())) return StartAgain(slots);
  if (!IsOversized(new_.capacity())) return;
  HookedVector<uint32_t> smaller;
  smaller.reserve(new_count_);
  for (const uint32_t id : new_) {
    if (id == kHole) continue;
    slots[id] = static_cast<uint32_t>(smaller.size()) | kMark;
    smaller.push_back(id);
  }
  new_.swap(smaller);
}

size_t BoxTree::native_bytes() const {
  return tree_.native_bytes() + states_.capacity() * sizeof(BlockState) +
         (order_.capacity() + new_.capacity() + changed_blocks_.capacity() + ids_.capacity()) *
             sizeof(uint32_t) +
         sorted_extents_.capacity() * sizeof(float) + placed_.capacity() * sizeof(uint64_t);
}

}  // namespace sweepstake
