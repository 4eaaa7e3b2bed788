// Insertion of new members into a BoxTree. Each goes to the block that grows least, and that block
// is sorted again. If a block has no room, its whole branch is sorted again, into as many branches
// as needed.
#include <algorithm>
#include <array>
#include <limits>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/proxies/box_tree.h"

namespace sweepstake {
namespace {

// The growth of a node's bounds if they must cover a box, and their extent afterwards, both summed
// over the axes. The values are scaled by kGrowthScale, so that they are finite for all boxes.
constexpr float kGrowthScale = 0.125F;
struct Growth {
  float more;
  float extent;

  bool operator<(const Growth& other) const {
    return more < other.more || (more == other.more && extent < other.extent);
  }
};

Growth GrowthOf(const BoxLanes& nodes, size_t node, const Aabb& box) {
  Growth growth{0, 0};
  for (size_t axis = 0; axis < 3; ++axis) {
    const float min = kGrowthScale * nodes.min[axis][node];
    const float max = kGrowthScale * nodes.max[axis][node];
    const float extent =
        std::max(max, kGrowthScale * box.max[axis]) - std::min(min, kGrowthScale * box.min[axis]);
    growth.more += extent - (max - min);
    growth.extent += extent;
  }
  return growth;
}

// Finds the block whose bounds grow least if they must cover a box; of several such blocks, the one
// with the smallest bounds afterwards. It visits at most kMaxVisited blocks. If very many blocks do
// not grow at all, for example for boxes in one place, it finds the best visited block.
class BlockChoice {
 public:
  static constexpr uint32_t kMaxVisited = 64;

  BlockChoice(const LeafTree::View& tree, const Aabb& box) : tree_(tree), box_(box) {
    Descend(tree.top, 0);
  }
  uint32_t block() const { return block_; }

 private:
  // Visits the children of a node in ascending order of growth. Stops at a child that grows more
  // than the best block, since all blocks below that child grow at least as much.
  void Descend(size_t level, size_t begin) {
    const BoxLanes& nodes = tree_.levels[level];
    const size_t count = std::min(nodes.count - begin, LeafTree::kWidth);
    std::array<Growth, LeafTree::kWidth> growths;
    for (size_t k = 0; k < count; ++k) growths[k] = GrowthOf(nodes, begin + k, box_);
    while (true) {
      const auto least = std::min_element(growths.begin(), growths.begin() + count);
      if (!(least->more <= best_.more) || visited_ == kMaxVisited) return;
      const size_t node = begin + static_cast<size_t>(least - growths.begin());
      if (level > 2) {
        Descend(level - 1, node * LeafTree::kWidth);
      } else {
        ++visited_;
        if (*least < best_) {
          best_ = *least;
          block_ = static_cast<uint32_t>(node);
        }
      }
      least->more = kInfinity;
    }
  }

  const LeafTree::View& tree_;
  const Aabb& box_;
  Growth best_{std::numeric_limits<float>::max(), kInfinity};
  uint32_t block_ = 0;
  uint32_t visited_ = 0;  // the number of visited blocks
};

// The minimum number of new members that get separate branches (a run, see InsertRun). Fewer would
// leave most of a branch free.
constexpr size_t kMinRun = 2000;
// The maximum mean extent of a run's blocks, as a multiple of the mean extent of the tree's blocks.
constexpr double kMaxRunExtent = 2;
// Inserting this number of members as a run degrades the tree as much as inserting one member into
// a block.
constexpr size_t kRunMembersPerNewOne = 8;

// If more than 1 in 64 members has to be inserted one by one, sorting all members takes less time.
// An insertion takes 8 µs, sorting 0.1 µs per member (AMD Zen 4).
constexpr size_t kMembersPerEach = 64;

// The mean of boxes' extents, each summed over the axes.
class MeanExtent {
 public:
  // Ignores bounds without a valid box, which are inverted.
  void Add(const BoxLanes& bounds, size_t at) {
    if (!(bounds.min[0][at] <= bounds.max[0][at])) return;
    for (size_t axis = 0; axis < 3; ++axis) {
      sum_ += static_cast<double>(bounds.max[axis][at]) - static_cast<double>(bounds.min[axis][at]);
    }
    ++count_;
  }
  double value() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

 private:
  double sum_ = 0;
  size_t count_ = 0;
};

BoxLanes LanesOf(const Aabb& box) {
  return {
      {&box.min[0], &box.min[1], &box.min[2]}, {&box.max[0], &box.max[1], &box.max[2]}, nullptr, 1};
}

// Returns the bounds of the valid boxes, or an invalid box if there are none.
Aabb BoundsOf(std::span<const Aabb> boxes, std::span<const uint32_t> ids) {
  Aabb bounds = kInvalidAabb;
  for (const uint32_t id : ids) {
    if (!IsValid(boxes[id])) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      bounds.min[axis] = std::min(bounds.min[axis], boxes[id].min[axis]);
      bounds.max[axis] = std::max(bounds.max[axis], boxes[id].max[axis]);
    }
  }
  return bounds;
}

}  // namespace

// Inserts the members in `new_`. Many members that are added at once and are close together, such
// as a tile of the world, get separate branches.
void BoxTree::InsertNew(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots) {
  // is_sorted_ is true again at the end. If memory runs out before that, the next Update sorts all
  // members.
  is_sorted_ = false;
  if (new_count_ < kMinRun || !InsertRun(boxes, splitter, slots)) {
    if (new_count_ * kMembersPerEach > count_) return SortMembers(boxes, splitter, slots);
    InsertEach(boxes, splitter, slots);
  }
  new_.clear();
  RefitChanged(boxes);
  is_sorted_ = true;
}

// Sorts the new members among themselves and writes them to separate branches. Returns false
// without a change if their blocks would be much larger than the tree's blocks, and so overlap many
// of them.
bool BoxTree::InsertRun(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots) {
  ids_.clear();
  for (const uint32_t id : new_) {
    if (id != kHole) ids_.push_back(id);
  }
  splitter.Sort(boxes, ids_, nullptr, kSortedLeaves);
  MeanExtent own;
  for (size_t begin = 0; begin < ids_.size(); begin += kSorted) {
    const size_t count = std::min(kSorted, ids_.size() - begin);
    const Aabb bounds = BoundsOf(boxes, std::span(ids_).subspan(begin, count));
    own.Add(LanesOf(bounds), 0);
  }
  MeanExtent of_tree;
  const BoxLanes& blocks = view().levels[2];
  for (size_t block = 0; block < blocks.count; ++block) of_tree.Add(blocks, block);
  if (!(own.value() <= kMaxRunExtent * of_tree.value())) return false;
  inserted_count_ += ids_.size() / kRunMembersPerNewOne;
  constexpr size_t kStep = LeafTree::kWidth * kSorted;
  ReserveSlots(order_.size() + (ids_.size() / kStep + 2) * kBranch);
  for (size_t begin = 0; begin < ids_.size(); begin += kStep) {
    WriteBranch(FreeBranch(0), begin, std::min(begin + kStep, ids_.size()), slots);
  }
  return true;
}

// Inserts each new member into its best block. Sorts a branch again if one of its blocks has no
// room.
void BoxTree::InsertEach(std::span<const Aabb> boxes, KdOrder& splitter,
                         std::span<uint32_t> slots) {
  placed_.clear();
  placed_.reserve(new_count_);
  for (const uint32_t id : new_) {
    if (id == kHole) continue;
    placed_.push_back(uint64_t{BlockChoice(view(), boxes[id]).block()} << 32 | id);
  }
  std::sort(placed_.begin(), placed_.end());
  for (size_t begin = 0, end = 0; begin < placed_.size(); begin = end) {
    const uint64_t branch = placed_[begin] >> (32 + LeafTree::kWidthBits);
    while (end < placed_.size() && placed_[end] >> (32 + LeafTree::kWidthBits) == branch) ++end;
    const auto placed = std::span<const uint64_t>(placed_).subspan(begin, end - begin);
    if (InsertIntoBlocks(placed, boxes, splitter, slots)) continue;
    SortBranch(branch, placed, boxes, splitter, slots);
  }
}

// Sorts each block again with the members placed in it. Returns false at the first block without
// room for them.
bool BoxTree::InsertIntoBlocks(std::span<const uint64_t> placed, std::span<const Aabb> boxes,
                               KdOrder& splitter, std::span<uint32_t> slots) {
  for (size_t begin = 0, end = 0; begin < placed.size(); begin = end) {
    const uint64_t block = placed[begin] >> 32;
    while (end < placed.size() && placed[end] >> 32 == block) ++end;
    ids_.clear();
    AppendMembers(block);
    if (ids_.size() + end - begin > kBlock) return false;
    for (size_t k = begin; k < end; ++k) ids_.push_back(static_cast<uint32_t>(placed[k]));
    splitter.Sort(boxes, ids_);
    WriteBlock(block, ids_, slots);
    inserted_count_ += end - begin;
  }
  return true;
}

// Sorts the members of the branch and the members in `placed` into one or more free branches. Skips
// entries of `placed` that InsertIntoBlocks has already inserted.
void BoxTree::SortBranch(size_t branch, std::span<const uint64_t> placed,
                         std::span<const Aabb> boxes, KdOrder& splitter,
                         std::span<uint32_t> slots) {
  const size_t first = branch * LeafTree::kWidth;
  ids_.clear();
  for (size_t k = 0; k < LeafTree::kWidth; ++k) AppendMembers(first + k);
  for (const uint64_t entry : placed) {
    const auto id = static_cast<uint32_t>(entry);
    if ((slots[id] & kMark) == 0) continue;
    ids_.push_back(id);
    ++inserted_count_;
  }
  splitter.Sort(boxes, ids_, nullptr, kSortedLeaves);
  const size_t block_count = (ids_.size() + kSorted - 1) / kSorted;
  const size_t branch_count = (block_count + LeafTree::kWidth - 1) / LeafTree::kWidth;
  const size_t step = (block_count + branch_count - 1) / branch_count * kSorted;
  ReserveSlots(order_.size() + branch_count * kBranch);
  for (size_t k = 0; k < LeafTree::kWidth; ++k) WriteBlock(first + k, {}, slots);
  for (size_t begin = 0; begin < ids_.size(); begin += step) {
    WriteBranch(FreeBranch(branch), begin, std::min(begin + step, ids_.size()), slots);
  }
}

// Writes the members [begin, end) of `ids_` to the branch. REQUIRES: the branch is free.
void BoxTree::WriteBranch(size_t branch, size_t begin, size_t end, std::span<uint32_t> slots) {
  size_t block = branch * LeafTree::kWidth;
  for (size_t at = begin; at < end; at += kSorted) {
    WriteBlock(block++, std::span(ids_).subspan(at, std::min(kSorted, end - at)), slots);
  }
}

// Appends the ids of the block's members to `ids_`, in the order of their slots.
void BoxTree::AppendMembers(size_t block) {
  const size_t end = std::min((block + 1) * kBlock, order_.size());
  for (size_t slot = block * kBlock; slot < end; ++slot) {
    if (order_[slot] != kHole) ids_.push_back(order_[slot]);
  }
}

// Replaces the members of the block by the members in `ids`. REQUIRES: ReserveSlots has made room
// for the slots of the block.
void BoxTree::WriteBlock(size_t block, std::span<const uint32_t> ids, std::span<uint32_t> slots) {
  const size_t first = block * kBlock;
  if (order_.size() < first + kBlock) {
    if (ids.empty()) return;
    order_.resize(first + kBlock, kHole);
    for (size_t next = states_.size(); next <= block; ++next) {
      states_.push_back(BlockState::kFresh);
      Mark(next, BlockState::kChanged);
    }
  }
  Mark(block, BlockState::kSorted);
  std::fill_n(order_.begin() + static_cast<std::ptrdiff_t>(first), kBlock, kHole);
  for (size_t k = 0; k < ids.size(); ++k) {
    uint32_t& slot = slots[ids[k]];
    if ((slot & kMark) != 0) {
      new_[slot & ~kMark] = kHole;
      --new_count_;
    }
    slot = static_cast<uint32_t>(first + k);
    order_[first + k] = ids[k];
  }
}

bool BoxTree::IsFree(size_t first_slot, size_t slot_count) const {
  const size_t end = std::min(first_slot + slot_count, order_.size());
  for (size_t slot = first_slot; slot < end; ++slot) {
    if (order_[slot] != kHole) return false;
  }
  return true;
}

// Returns the first free branch from `from` on, wrapping around at the end, or else a new branch.
size_t BoxTree::FreeBranch(size_t from) const {
  const size_t branch_count = (order_.size() + kBranch - 1) / kBranch;
  for (size_t k = 0; k < branch_count; ++k) {
    const size_t branch = (from + k) % branch_count;
    if (IsFree(branch * kBranch, kBranch)) return branch;
  }
  return branch_count;
}

// Grows by half, so that allocations are rare while the tree grows.
void BoxTree::ReserveSlots(size_t slot_count) {
  if (slot_count <= order_.capacity() && slot_count / kBlock <= states_.capacity()) return;
  const size_t grown = std::max(slot_count, order_.size() + order_.size() / 2);
  ReserveBlocks(grown / kBlock + 1);
  order_.reserve(grown);
}

}  // namespace sweepstake
