#include "engine_client/broad_phase/proxies/box_tree.h"

#include <algorithm>

namespace sweepstake {
namespace {

// The cost of making an order, in checks per box.
constexpr uint64_t kChecksPerSort = 20;
// One member in so many may be behind the order. After a million adds and removes queries take 1.07
// times what they take in a tree that was sorted at once, with one in 32 they took 1.25 times
// (tests/bench/programs/proxy_ratios_bench.cc, AMD Zen 4).
constexpr size_t kMembersPerNewOne = 128;

}  // namespace

void BoxTree::EnsureRoomFor(size_t new_members) {
  const size_t needed = order_.size() + new_members;
  if (needed <= order_.capacity()) return;
  order_.reserve(order_.empty() ? needed : std::max(needed, 2 * order_.size()));
}

void BoxTree::Add(uint32_t id, std::span<uint32_t> slots) {
  // Members that come and go without an Update between them must not take ever more slots.
  if (HasManyHoles()) {
    CloseHoles(0);
    NumberSlots(0, slots);
    first_new_ = 0;
  }
  order_.push_back(id);
  slots[id] = static_cast<uint32_t>(order_.size() - 1);
  ++count_;
  any_new_ = true;
}

void BoxTree::Remove(uint32_t slot) {
  order_[slot] = KdOrder::kHole;
  --count_;
}

void BoxTree::Update(std::span<const Aabb> boxes, KdOrder& splitter, std::span<uint32_t> slots) {
  const size_t new_slots = order_.size() - std::min(first_new_, order_.size());
  if (first_new_ == 0 || HasManyHoles() || new_slots * kMembersPerNewOne > count_) {
    SortMembers(boxes, splitter, slots);
    return;
  }
  if (any_new_) SortNewMembers(boxes, splitter, slots);
  Refit(boxes);
  if (SortIsDue()) SortMembers(boxes, splitter, slots);
}

// Fills the last leaf with holes, so that what is added later begins with a leaf of its own.
void BoxTree::SortMembers(std::span<const Aabb> boxes, KdOrder& splitter,
                          std::span<uint32_t> slots) {
  CloseHoles(0);
  if (!order_.empty()) splitter.Sort(boxes, order_);
  NumberSlots(0, slots);
  first_new_ = (count_ + LeafTree::kWidth - 1) / LeafTree::kWidth * LeafTree::kWidth;
  order_.resize(first_new_, KdOrder::kHole);
  any_new_ = false;
  Refit(boxes);
  debt_.Clear();
  sorted_extents_.resize(tree_.leaves().size());
  for (size_t leaf = 0; leaf < sorted_extents_.size(); ++leaf) {
    sorted_extents_[leaf] = ExtentOf(leaf);
  }
}

void BoxTree::SortNewMembers(std::span<const Aabb> boxes, KdOrder& splitter,
                             std::span<uint32_t> slots) {
  CloseHoles(first_new_);
  const std::span<uint32_t> added = std::span(order_).subspan(first_new_);
  if (!added.empty()) splitter.Sort(boxes, added);
  NumberSlots(first_new_, slots);
  any_new_ = false;
}

void BoxTree::CloseHoles(size_t begin) {
  order_.erase(std::remove(order_.begin() + static_cast<std::ptrdiff_t>(begin), order_.end(),
                           KdOrder::kHole),
               order_.end());
}

void BoxTree::NumberSlots(size_t begin, std::span<uint32_t> slots) const {
  for (size_t slot = begin; slot < order_.size(); ++slot) {
    slots[order_[slot]] = static_cast<uint32_t>(slot);
  }
}

bool BoxTree::SortIsDue() const {
  return count_ > 0 && (debt_.Exceeds(kChecksPerSort * count_) || HasGrown());
}

// Leaves are counted, since in a sum one box that has flown far away would outweigh all others.
bool BoxTree::HasGrown() const {
  size_t grown = 0;
  for (size_t leaf = 0; leaf < sorted_extents_.size(); ++leaf) {
    if (ExtentOf(leaf) > 2 * sorted_extents_[leaf]) ++grown;
  }
  return grown * 8 > sorted_extents_.size();
}

// Returns the sum over the axes; 0 if the leaf has no valid box.
float BoxTree::ExtentOf(size_t leaf) const {
  const BoxLanes& bounds = view().levels[1];
  float sum = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    sum += std::max(0.0F, bounds.max[axis][leaf] - bounds.min[axis][leaf]);
  }
  return sum;
}

}  // namespace sweepstake
