#include "engine_client/broad_phase/dbvt/dbvt_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/dbvt/dbvt_refit.h"

namespace sweepstake {
namespace {

// The assumed mean number of objects per node, used to reserve memory. After Build, all 16 lanes of
// a leaf are in use; after some motion, 11 to 13 of them.
constexpr size_t kObjectsPerNode = 10;

void SetBox(DbvtNode& node, uint32_t lane, const Aabb& box) {
  for (size_t axis = 0; axis < 3; ++axis) {
    node.min[axis][lane] = box.min[axis];
    node.max[axis][lane] = box.max[axis];
  }
}

Aabb BoxAt(const DbvtNode& node, uint32_t lane) {
  return {{node.min[0][lane], node.min[1][lane], node.min[2][lane]},
          {node.max[0][lane], node.max[1][lane], node.max[2][lane]}};
}

Aabb Union(const Aabb& a, const Aabb& b) {
  Aabb both;
  for (size_t axis = 0; axis < 3; ++axis) {
    both.min[axis] = std::min(a.min[axis], b.min[axis]);
    both.max[axis] = std::max(a.max[axis], b.max[axis]);
  }
  return both;
}

float SumOfSides(const Aabb& box) {
  return (box.max[0] - box.min[0]) + (box.max[1] - box.min[1]) + (box.max[2] - box.min[2]);
}

// Returns twice the box's center, as a double, since the sum of two floats may overflow.
double DoubledCenter(const Aabb& box, int axis) {
  return static_cast<double>(box.min[axis]) + box.max[axis];
}

// Returns the axis with the widest spread of the centers of the entries' boxes.
template <class Entries>
int WidestAxis(const Entries& entries) {
  int widest = 0;
  double max_spread = -1;
  for (int axis = 0; axis < 3; ++axis) {
    double low = DoubledCenter(entries[0].box, axis);
    double high = low;
    for (const auto& entry : entries) {
      low = std::min(low, DoubledCenter(entry.box, axis));
      high = std::max(high, DoubledCenter(entry.box, axis));
    }
    if (high - low <= max_spread) continue;
    max_spread = high - low;
    widest = axis;
  }
  return widest;
}

// The lane of a node's outermost face on one side, and the distance by which the node would shrink
// without that lane. The outermost face is the lowest if `sign` is +1, and the highest if it is −1.
struct Outermost {
  uint32_t lane;
  float gain;
};
Outermost OutermostLane(const float* faces, uint32_t count, float sign) {
  float first = kInfinity;
  float second = kInfinity;
  uint32_t lane = 0;
  for (uint32_t k = 0; k < count; ++k) {
    const float face = sign * faces[k];
    second = std::min(second, std::max(face, first));
    if (face < first) lane = k;
    first = std::min(face, first);
  }
  return {lane, second - first};
}

// Returns the lane whose removal shrinks the node most.
uint32_t LaneToEvict(const DbvtNode& node, uint32_t count) {
  std::array<float, DbvtNode::kWidth> gains{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const Outermost low = OutermostLane(node.min[axis], count, 1);
    const Outermost high = OutermostLane(node.max[axis], count, -1);
    gains[low.lane] += low.gain;
    gains[high.lane] += high.gain;
  }
  return static_cast<uint32_t>(std::max_element(gains.begin(), gains.begin() + count) -
                               gains.begin());
}

}  // namespace

uint32_t DbvtTree::AllocateNode(uint32_t level) {
  uint32_t node = free_;
  if (node != kNone) {
    free_ = links_[node].parent;
  } else {
    nodes_.EnsureKeeping(node_limit_ + 1, node_limit_);
    links_.EnsureKeeping(node_limit_ + 1, node_limit_);
    node = static_cast<uint32_t>(node_limit_++);
  }
  links_[node] = {kNone, 0, 0, static_cast<uint8_t>(level)};
  DbvtNode& fresh = nodes_[node];
  for (size_t axis = 0; axis < 3; ++axis) {
    std::fill_n(fresh.min[axis], kWidth, kInfinity);
    std::fill_n(fresh.max[axis], kWidth, -kInfinity);
  }
  std::fill_n(fresh.child, kWidth, 0U);
  std::fill_n(fresh.reach, kWidth, kInfinity);
  return node;
}

void DbvtTree::FreeNode(uint32_t node) {
  links_[node].parent = free_;
  free_ = node;
}

void DbvtTree::LinkChild(uint32_t node, uint32_t lane, uint32_t child) {
  nodes_[node].child[lane] = child;
  nodes_[node].reach[lane] = kInfinity;
  if (links_[node].level == 0) {
    slots_[child] = node * kWidth + lane;
    return;
  }
  links_[child].parent = node;
  links_[child].lane = static_cast<uint8_t>(lane);
  is_order_known_ = false;
}

void DbvtTree::SetLane(uint32_t node, uint32_t lane, const Entry& entry) {
  SetBox(nodes_[node], lane, entry.box);
  LinkChild(node, lane, entry.child);
}

DbvtTree::Entry DbvtTree::EntryAt(uint32_t node, uint32_t lane) const {
  return {BoxAt(nodes_[node], lane), nodes_[node].child[lane], links_[node].level};
}

// Removes the entry in `lane` and moves the last entry into that lane.
void DbvtTree::RemoveLane(uint32_t node, uint32_t lane) {
  const uint32_t last = --links_[node].count;
  const float reach = nodes_[node].reach[last];
  if (lane != last) {
    SetLane(node, lane, EntryAt(node, last));
    nodes_[node].reach[lane] = reach;
  }
  SetBox(nodes_[node], last, kInvalidAabb);
  is_order_known_ &= links_[node].level == 0;
}

void DbvtTree::EvictLane(uint32_t node, uint32_t lane) {
  waiting_.push_back(EntryAt(node, lane));
  RemoveLane(node, lane);
}

// Removes the node and appends its entries to waiting_, from which Settle inserts them elsewhere.
// REQUIRES: the node is not the root.
void DbvtTree::RemoveNode(uint32_t node) {
  for (uint32_t lane = links_[node].count; lane-- > 0;) EvictLane(node, lane);
  RemoveLane(links_[node].parent, links_[node].lane);
  FreeNode(node);
}

void DbvtTree::WriteBounds(uint32_t node) {
  SetBox(nodes_[links_[node].parent], links_[node].lane, NodeBounds(nodes_[node]));
}

void DbvtTree::TightenUpFrom(uint32_t node) {
  while (node != root_) {
    const uint32_t parent = links_[node].parent;
    links_[node].count < kMinFill ? RemoveNode(node) : WriteBounds(node);
    node = parent;
  }
}

void DbvtTree::Reserve(size_t object_count) {
  const size_t node_count = object_count / kObjectsPerNode + 2 * kMaxLevels;
  nodes_.EnsureDiscarding(node_count);
  links_.EnsureDiscarding(node_count);
  slots_.EnsureDiscarding(object_count);
  inner_.reserve(node_count / kMinFill);
  groups_.reserve(node_count / kMinFill);
  notes_.reserve(node_count / kMinFill);
}

void DbvtTree::Build(std::span<const Aabb> boxes, std::span<const uint32_t> slots,
                     Executor* executor, HookedVector<uint32_t>& lost, StopRequest* stop) {
  Reserve(boxes.size());
  object_count_ = boxes.size();
  std::fill_n(slots_.data(), object_count_, kNone);
  node_limit_ = 0;
  free_ = kNone;
  waiting_.clear();
  is_order_known_ = false;
  for (size_t first = 0; first < slots.size(); first += kWidth) {
    BuildLeaf(slots.subspan(first, std::min<size_t>(kWidth, slots.size() - first)));
  }
  uint32_t first = 0;
  uint32_t level = 0;
  do {
    const auto end = static_cast<uint32_t>(node_limit_);
    BuildLevel(++level, first, end);
    first = end;
  } while (node_limit_ - first > 1);
  root_ = first;
  if (IsStopped(stop)) return;
  // The nodes have no boxes yet: Refit reads the objects' boxes and computes all bounds.
  Refit(boxes, 0, executor, lost);
  Settle();
}

void DbvtTree::BuildLeaf(std::span<const uint32_t> objects) {
  uint32_t leaf = kNone;
  for (const uint32_t object : objects) {
    if (object >= object_count_) continue;
    if (leaf == kNone) leaf = AllocateNode(0);
    LinkChild(leaf, links_[leaf].count++, object);
  }
}

// Makes the parents of the nodes [first, end). The parents form the next level. Makes at least one.
void DbvtTree::BuildLevel(uint32_t level, uint32_t first, uint32_t end) {
  uint32_t node = AllocateNode(level);
  for (uint32_t child = first; child < end; ++child) {
    if (links_[node].count == kWidth) node = AllocateNode(level);
    LinkChild(node, links_[node].count++, child);
  }
}

void DbvtTree::Resize(size_t object_count) {
  slots_.EnsureKeeping(object_count, std::min(object_count, object_count_));
  for (size_t object = object_count_; object < object_count; ++object) slots_[object] = kNone;
  object_count_ = object_count;
}

void DbvtTree::Insert(uint32_t object, const Aabb& box) {
  assert(!Contains(object));
  Attach({box, object, 0});
}

void DbvtTree::Remove(uint32_t object) {
  assert(Contains(object));
  const uint32_t leaf = slots_[object] / kWidth;
  RemoveLane(leaf, slots_[object] % kWidth);
  slots_[object] = kNone;
  TightenUpFrom(leaf);
  Settle();
}

void DbvtTree::Move(uint32_t object, const Aabb& box) {
  assert(Contains(object));
  const uint32_t leaf = slots_[object] / kWidth;
  if (FitsInReach(leaf, box)) {
    SetBox(nodes_[leaf], slots_[object] % kWidth, box);
    WidenUpFrom(leaf, box);
  } else {
    Remove(object);
    Insert(object, box);
  }
}

// Returns whether the node stays within its reach if it also covers `box`. Returns false if the
// reach is not known yet.
bool DbvtTree::FitsInReach(uint32_t node, const Aabb& box) const {
  const DbvtNode& parent = nodes_[links_[node].parent];
  const uint32_t lane = links_[node].lane;
  const float sides = SumOfSides(Union(BoxAt(parent, lane), box));
  return sides <= parent.reach[lane] && parent.reach[lane] < kInfinity;
}

void DbvtTree::WidenUpFrom(uint32_t node, const Aabb& box) {
  for (; node != root_; node = links_[node].parent) {
    DbvtNode& parent = nodes_[links_[node].parent];
    const Aabb around = BoxAt(parent, links_[node].lane);
    const Aabb wider = Union(around, box);
    if (wider == around) return;
    SetBox(parent, links_[node].lane, wider);
  }
}

void DbvtTree::Attach(const Entry& entry) {
  if (links_[root_].count == 0) {
    links_[root_].level = static_cast<uint8_t>(std::max(entry.level, 1U));
    if (entry.level == 0) AddTo(root_, {entry.box, AllocateNode(0), 1});
  }
  AddTo(DescendWidening(nodes_.data(), links_.data(), root_, entry.level, entry.box), entry);
}

// Adds the entry to a node. REQUIRES: the boxes of all ancestors of the node cover the entry's box.
void DbvtTree::AddTo(uint32_t node, const Entry& entry) {
  if (links_[node].count == kWidth) return Split(node, entry);
  SetLane(node, links_[node].count++, entry);
}

// Divides the entries of a full node and one more entry between two nodes. It splits at the median
// of the axis with the widest spread of centers.
void DbvtTree::Split(uint32_t node, const Entry& entry) {
  std::array<Entry, kWidth + 1> entries;
  for (uint32_t lane = 0; lane < kWidth; ++lane) entries[lane] = EntryAt(node, lane);
  entries[kWidth] = entry;
  const int axis = WidestAxis(entries);
  std::nth_element(entries.begin(), entries.begin() + kWidth / 2, entries.end(),
                   [axis](const Entry& a, const Entry& b) {
                     return DoubledCenter(a.box, axis) < DoubledCenter(b.box, axis);
                   });

  const uint32_t level = links_[node].level;
  const uint32_t sibling = AllocateNode(level);
  while (links_[node].count > 0) RemoveLane(node, links_[node].count - 1U);
  for (size_t k = 0; k < entries.size(); ++k) {
    const uint32_t half = k < kWidth / 2 ? node : sibling;
    SetLane(half, links_[half].count++, entries[k]);
  }
  if (node == root_) {
    root_ = AllocateNode(level + 1);
    AddTo(root_, {NodeBounds(nodes_[node]), node, level + 1});
  } else {
    WriteBounds(node);
  }
  AddTo(links_[node].parent, {NodeBounds(nodes_[sibling]), sibling, level + 1});
}

void DbvtTree::Settle(StopRequest* stop) {
  constexpr size_t kEntriesPerQuestion = 2048;
  // Inserts large subtrees first, because smaller subtrees and objects may be inserted into these
  // subtrees.
  for (uint32_t level = links_[root_].level + 1; level-- > 0 && !waiting_.empty();) {
    const auto attach = [&](size_t begin, size_t end) {
      for (size_t k = begin; k < end; ++k) {
        if (waiting_[k].level == level) Attach(waiting_[k]);
      }
    };
    if (!ForEachBlock(stop, 0, waiting_.size(), attach, kEntriesPerQuestion)) break;
  }
  waiting_.clear();
  while (links_[root_].level > 1 && links_[root_].count == 1) {
    const uint32_t old_root = root_;
    root_ = nodes_[old_root].child[0];
    links_[root_].parent = kNone;
    FreeNode(old_root);
    is_order_known_ = false;
  }
}

// Evicts entries until the node is within its reach again, or removes the node if too few are left.
void DbvtTree::EvictToReach(uint32_t node) {
  const float reach = nodes_[links_[node].parent].reach[links_[node].lane];
  while (links_[node].count >= kMinFill) {
    const Aabb bounds = NodeBounds(nodes_[node]);
    if (!(SumOfSides(bounds) > reach)) {
      SetBox(nodes_[links_[node].parent], links_[node].lane, bounds);
      return;
    }
    EvictLane(node, LaneToEvict(nodes_[node], links_[node].count));
  }
  RemoveNode(node);
}

// Calls EvictToReach for the children in the lanes `stretched`. It starts at the highest lane,
// since removing a child moves the last child into its lane.
void DbvtTree::EvictBelow(uint32_t node, uint32_t stretched) {
  while (stretched != 0) {
    const auto lane = static_cast<uint32_t>(std::bit_width(stretched)) - 1;
    stretched ^= 1U << lane;
    EvictToReach(nodes_[node].child[lane]);
  }
}

void DbvtTree::RemoveInvalid(uint32_t leaf, std::span<const Aabb> boxes,
                             HookedVector<uint32_t>& lost) {
  for (uint32_t lane = links_[leaf].count; lane-- > 0;) {
    const uint32_t object = nodes_[leaf].child[lane];
    if (IsValid(boxes[object])) continue;
    slots_[object] = kNone;
    lost.push_back(object);
    RemoveLane(leaf, lane);
  }
}

void DbvtTree::RefitGroups(std::span<const Aabb> boxes, float step, Executor* executor) {
  CollectOrder();
  notes_.resize(groups_.size());
  const size_t part_count = PartCount(executor, groups_.size(), kMinGroupsPerPart);
  RunParts(executor, part_count, [&](size_t part) {
    const PartRange range = RangeOfPart(groups_.size(), part, part_count, 1);
    for (size_t k = range.begin; k < range.end; ++k) {
      notes_[k] = RefitGroup(nodes_.data(), links_.data(), groups_[k], boxes.data(), step);
    }
  });
}

void DbvtTree::TakeBoxes(std::span<const Aabb> boxes, Executor* executor) {
  RefitGroups(boxes, 0, executor);
  for (size_t k = inner_.size(); k-- > 0;) {
    if (inner_[k] != root_) WriteBounds(inner_[k]);
  }
}

DbvtTree::Motion DbvtTree::SumUpNotes() const {
  Motion motion{};
  size_t stretched = 0;
  for (size_t k = 0; k < groups_.size(); ++k) {
    motion.sample_count += links_[groups_[k]].count;
    motion.fast_count += notes_[k].fast_count;
    motion.mean += notes_[k].motion;
    stretched += static_cast<size_t>(std::popcount(notes_[k].stretched));
  }
  motion.mean /= static_cast<float>(std::max<size_t>(motion.sample_count, 1));
  motion.needs_build = 2 * stretched > motion.sample_count;
  return motion;
}

DbvtTree::Motion DbvtTree::Refit(std::span<const Aabb> boxes, float step, Executor* executor,
                                 HookedVector<uint32_t>& lost) {
  RefitGroups(boxes, step, executor);
  const Motion motion = SumUpNotes();
  if (motion.needs_build) return motion;
  size_t group = groups_.size();
  for (size_t k = inner_.size(); k-- > 0;) {
    const uint32_t node = inner_[k];
    if (links_[node].level > 1) {
      EvictBelow(node, StretchedLanes(nodes_[node]));
    } else {
      const DbvtGroupNote& note = notes_[--group];
      for (uint32_t left = note.invalid; left != 0; left &= left - 1) {
        RemoveInvalid(nodes_[node].child[std::countr_zero(left)], boxes, lost);
      }
      EvictBelow(node, note.stretched | note.invalid);
    }
    if (node != root_) links_[node].count < kMinFill ? RemoveNode(node) : WriteBounds(node);
  }
  return motion;
}

void DbvtTree::CollectOrder() {
  if (is_order_known_) return;
  inner_.clear();
  groups_.clear();
  std::array<uint32_t, kMaxLevels * kWidth> stack;
  size_t waiting = 0;
  stack[waiting++] = root_;
  while (waiting > 0) {
    const uint32_t node = stack[--waiting];
    inner_.push_back(node);
    if (links_[node].level == 1) {
      groups_.push_back(node);
      continue;
    }
    for (uint32_t lane = links_[node].count; lane-- > 0;) {
      stack[waiting++] = nodes_[node].child[lane];
    }
  }
  is_order_known_ = true;
}

std::span<const uint32_t> DbvtTree::Groups() {
  CollectOrder();
  return groups_;
}

size_t DbvtTree::native_bytes() const {
  return nodes_.capacity_bytes() + links_.capacity_bytes() + slots_.capacity_bytes() +
         waiting_.capacity() * sizeof(Entry) +
         (inner_.capacity() + groups_.capacity()) * sizeof(uint32_t) +
         notes_.capacity() * sizeof(DbvtGroupNote);
}

}  // namespace sweepstake
