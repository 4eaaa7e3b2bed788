#include "engine_client/broad_phase/dbvt_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>

namespace sweepstake {
namespace {

// In double: the product of two extents of the largest floats is finite there.
double SurfaceArea(const DbvtNode& box) {
  const double x = static_cast<double>(box.max[0]) - box.min[0];
  const double y = static_cast<double>(box.max[1]) - box.min[1];
  const double z = static_cast<double>(box.max[2]) - box.min[2];
  return x * y + y * z + z * x;
}

DbvtNode Union(const DbvtNode& a, const DbvtNode& b) {
  DbvtNode both = a;
  for (int axis = 0; axis < 3; ++axis) {
    both.min[axis] = std::min(a.min[axis], b.min[axis]);
    both.max[axis] = std::max(a.max[axis], b.max[axis]);
  }
  return both;
}

bool SameBox(const DbvtNode& a, const DbvtNode& b) {
  return std::equal(a.min, a.min + 3, b.min) && std::equal(a.max, a.max + 3, b.max);
}

bool Covers(const DbvtNode& outer, const DbvtNode& inner) {
  for (int axis = 0; axis < 3; ++axis) {
    if (outer.min[axis] > inner.min[axis] || outer.max[axis] < inner.max[axis]) return false;
  }
  return true;
}

int WidestAxis(const float (&low)[3], const float (&high)[3]) {
  int widest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    // Halves: the difference of two finite floats need not be finite.
    const float extent = high[axis] * 0.5F - low[axis] * 0.5F;
    if (extent > high[widest] * 0.5F - low[widest] * 0.5F) widest = axis;
  }
  return widest;
}

}  // namespace

uint32_t DbvtTree::MaxHeight(size_t leaf_count) {
  return 2 * static_cast<uint32_t>(std::bit_width(leaf_count)) + 4;
}

void DbvtTree::Reset(size_t leaf_count) {
  const size_t node_count = leaf_count == 0 ? 0 : 2 * leaf_count - 1;
  leaf_count_ = leaf_count;
  size_ = 0;
  root_ = kNone;
  free_ = kNone;
  next_unused_ = static_cast<uint32_t>(leaf_count);
  nodes_.resize(node_count);
  parents_.assign(node_count, kNone);
  heights_.assign(node_count, 0);
  present_.assign(leaf_count, 0);
  centers_.reserve(leaf_count);
  order_.reserve(leaf_count);
  inner_order_.reserve(leaf_count);
}

Aabb DbvtTree::box(uint32_t node) const {
  const DbvtNode& from = nodes_[node];
  return {{from.min[0], from.min[1], from.min[2]}, {from.max[0], from.max[1], from.max[2]}};
}

size_t DbvtTree::native_bytes() const {
  return nodes_.capacity() * sizeof(DbvtNode) + parents_.capacity() * sizeof(uint32_t) +
         heights_.capacity() * sizeof(uint32_t) + present_.capacity() +
         centers_.capacity() * sizeof(Center) +
         (order_.capacity() + inner_order_.capacity()) * sizeof(uint32_t);
}

uint32_t DbvtTree::AllocateNode() {
  if (free_ == kNone) return next_unused_++;
  const uint32_t node = free_;
  free_ = nodes_[node].first;
  return node;
}

void DbvtTree::FreeNode(uint32_t node) {
  nodes_[node].first = free_;
  free_ = node;
}

void DbvtTree::SetBox(uint32_t leaf, const Aabb& box) {
  DbvtNode& node = nodes_[leaf];
  std::copy_n(box.min, 3, node.min);
  std::copy_n(box.max, 3, node.max);
  size_ += present_[leaf] == 0 ? 1 : 0;
  present_[leaf] = 1;
}

void DbvtTree::Insert(uint32_t leaf, const Aabb& box) {
  assert(!Contains(leaf));
  SetBox(leaf, box);
  Attach(leaf, root_);
  BoundHeight();
}

void DbvtTree::Move(uint32_t leaf, const Aabb& box) {
  assert(Contains(leaf));
  const uint32_t near = Detach(leaf);
  SetBox(leaf, box);
  Attach(leaf, near == kNone ? root_ : LowestContaining(near, nodes_[leaf]));
  BoundHeight();
}

void DbvtTree::Remove(uint32_t leaf) {
  assert(Contains(leaf));
  Detach(leaf);
  present_[leaf] = 0;
  --size_;
  BoundHeight();
}

// Cost of a sibling: the area of the new parent, and what every ancestor grows by.
uint32_t DbvtTree::ChooseSibling(const DbvtNode& box, uint32_t start) const {
  uint32_t node = start;
  while (!IsLeaf(node)) {
    const double here = SurfaceArea(Union(nodes_[node], box));
    const double inherited = here - SurfaceArea(nodes_[node]);
    std::array<double, 2> below;
    const std::array<uint32_t, 2> children = {nodes_[node].first, nodes_[node].second};
    for (size_t i = 0; i < 2; ++i) {
      const DbvtNode& child = nodes_[children[i]];
      below[i] = SurfaceArea(Union(child, box)) + inherited;
      if (!IsLeaf(children[i])) below[i] -= SurfaceArea(child);
    }
    if (here < below[0] && here < below[1]) break;
    // Equal costs, as between coincident boxes: the lower side, or the tree becomes a list.
    const bool second =
        below[0] == below[1] ? heights_[children[1]] < heights_[children[0]] : below[1] < below[0];
    node = children[second ? 1 : 0];
  }
  return node;
}

uint32_t DbvtTree::LowestContaining(uint32_t node, const DbvtNode& box) const {
  while (parents_[node] != kNone && !Covers(nodes_[node], box)) node = parents_[node];
  return node;
}

void DbvtTree::ReplaceChild(uint32_t parent, uint32_t old_child, uint32_t new_child) {
  parents_[new_child] = parent;
  if (parent == kNone) {
    root_ = new_child;
  } else if (nodes_[parent].first == old_child) {
    nodes_[parent].first = new_child;
  } else {
    nodes_[parent].second = new_child;
  }
}

void DbvtTree::Attach(uint32_t leaf, uint32_t start) {
  if (root_ == kNone) {
    root_ = leaf;
    parents_[leaf] = kNone;
    return;
  }
  const uint32_t sibling = ChooseSibling(nodes_[leaf], start);
  const uint32_t joint = AllocateNode();
  ReplaceChild(parents_[sibling], sibling, joint);
  nodes_[joint].first = sibling;
  nodes_[joint].second = leaf;
  parents_[sibling] = joint;
  parents_[leaf] = joint;
  Pull(joint);
  PullUpFrom(parents_[joint]);
}

// Returns a node near the place that the leaf left, kNone when no inner node is left there.
uint32_t DbvtTree::Detach(uint32_t leaf) {
  const uint32_t joint = parents_[leaf];
  if (joint == kNone) {
    root_ = kNone;
    return kNone;
  }
  const uint32_t sibling = nodes_[joint].first == leaf ? nodes_[joint].second : nodes_[joint].first;
  const uint32_t above = parents_[joint];
  ReplaceChild(above, joint, sibling);
  FreeNode(joint);
  PullUpFrom(above);
  return sibling;
}

// Box and height of an inner node from its children. Returns whether either changed.
bool DbvtTree::Pull(uint32_t node) {
  DbvtNode& at = nodes_[node];
  DbvtNode joined = Union(nodes_[at.first], nodes_[at.second]);
  joined.first = at.first;
  joined.second = at.second;
  const uint32_t height = 1 + std::max(heights_[at.first], heights_[at.second]);
  const bool changed = height != heights_[node] || !SameBox(joined, at);
  at = joined;
  heights_[node] = height;
  return changed;
}

// Where one child is higher by more than one, it takes the node's place and the node its lower
// grandchild. Returns the node that now stands there.
uint32_t DbvtTree::Rotate(uint32_t node) {
  const uint32_t first = nodes_[node].first;
  const uint32_t second = nodes_[node].second;
  const uint32_t high = heights_[first] > heights_[second] ? first : second;
  const uint32_t low = high == first ? second : first;
  if (heights_[high] <= heights_[low] + 1) return node;

  uint32_t stays = nodes_[high].first;
  uint32_t moves = nodes_[high].second;
  if (heights_[stays] < heights_[moves]) std::swap(stays, moves);
  ReplaceChild(parents_[node], node, high);
  ReplaceChild(node, high, moves);
  nodes_[high].first = node;
  nodes_[high].second = stays;
  parents_[node] = high;
  Pull(node);
  Pull(high);
  return high;
}

void DbvtTree::PullUpFrom(uint32_t node) {
  while (node != kNone) {
    const bool changed = Pull(node);
    const uint32_t top = Rotate(node);
    if (!changed && top == node) return;
    node = parents_[top];
  }
}

void DbvtTree::BoundHeight() {
  if (height() > MaxHeight(size_)) Rebuild();
}

void DbvtTree::CollectCenters() {
  centers_.clear();
  for (uint32_t leaf = 0; leaf < leaf_count_; ++leaf) {
    if (!Contains(leaf)) continue;
    const DbvtNode& box = nodes_[leaf];
    Center center{{}, leaf};
    for (int axis = 0; axis < 3; ++axis) {
      center.at[axis] = box.min[axis] * 0.5F + box.max[axis] * 0.5F;
    }
    centers_.push_back(center);
  }
}

// Orders the range around its median on its widest axis and returns the middle.
uint32_t DbvtTree::SplitRange(const Range& range) {
  float low[3] = {centers_[range.begin].at[0], centers_[range.begin].at[1],
                  centers_[range.begin].at[2]};
  float high[3] = {low[0], low[1], low[2]};
  for (uint32_t i = range.begin + 1; i < range.end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], centers_[i].at[axis]);
      high[axis] = std::max(high[axis], centers_[i].at[axis]);
    }
  }
  const int axis = WidestAxis(low, high);
  const uint32_t middle = range.begin + (range.end - range.begin) / 2;
  std::nth_element(centers_.begin() + range.begin, centers_.begin() + middle,
                   centers_.begin() + range.end,
                   [axis](const Center& a, const Center& b) { return a.at[axis] < b.at[axis]; });
  return middle;
}

void DbvtTree::Rebuild() {
  CollectCenters();
  root_ = kNone;
  free_ = kNone;
  next_unused_ = static_cast<uint32_t>(leaf_count_);
  if (centers_.empty()) {
    order_.clear();
    return;
  }
  std::array<Range, kStackSize> stack;
  size_t waiting = 0;
  stack[waiting++] = {0, static_cast<uint32_t>(centers_.size()), kNone, false};
  while (waiting > 0) {
    const Range range = stack[--waiting];
    const bool is_leaf = range.end - range.begin == 1;
    const uint32_t node = is_leaf ? centers_[range.begin].leaf : AllocateNode();
    parents_[node] = range.parent;
    if (range.parent == kNone)
      root_ = node;
    else
      (range.is_second ? nodes_[range.parent].second : nodes_[range.parent].first) = node;
    if (is_leaf) continue;
    const uint32_t middle = SplitRange(range);
    stack[waiting++] = {middle, range.end, node, true};
    stack[waiting++] = {range.begin, middle, node, false};
  }
  Refit();
}

void DbvtTree::CollectOrder() {
  order_.clear();
  inner_order_.clear();
  if (root_ == kNone) return;
  std::array<uint32_t, kStackSize> stack;
  size_t waiting = 0;
  stack[waiting++] = root_;
  while (waiting > 0) {
    const uint32_t node = stack[--waiting];
    if (IsLeaf(node)) {
      order_.push_back(node);
      continue;
    }
    inner_order_.push_back(node);
    stack[waiting++] = nodes_[node].second;
    stack[waiting++] = nodes_[node].first;
  }
}

void DbvtTree::Refit() {
  CollectOrder();
  for (auto node = inner_order_.rbegin(); node != inner_order_.rend(); ++node) Pull(*node);
}

}  // namespace sweepstake
