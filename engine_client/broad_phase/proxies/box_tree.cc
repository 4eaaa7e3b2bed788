#include "engine_client/broad_phase/proxies/box_tree.h"

#include <algorithm>
#include <numeric>

namespace sweepstake {
namespace {

// The cost of making an order, in checks per box.
constexpr uint64_t kChecksPerSort = 20;

}  // namespace

void BoxTree::Update(std::span<const Aabb> boxes) {
  if (boxes.size() != count_) Resize(boxes.size());
  Refit(boxes);
  if (SortIsDue()) Sort(boxes);
}

// Adds or removes boxes at the end. New ones are appended in leaves that count as grown. If boxes
// are removed, the order is made again, since any leaf may have held them.
void BoxTree::Resize(size_t count) {
  order_.EnsureKeeping(count, std::min(count, count_));
  if (count < count_) {
    std::iota(order_.data(), order_.data() + count, 0U);
    sorted_leaf_count_ = 0;
  } else {
    std::iota(order_.data() + count_, order_.data() + count, static_cast<uint32_t>(count_));
  }
  count_ = count;
}

void BoxTree::Sort(std::span<const Aabb> boxes) {
  splitter_.Begin(tree_.leaves(), count_);
  splitter_.Finish(nullptr);
  splitter_.TakeBoxes({order_.data(), count_});
  Refit(boxes);
  debt_.Clear();
  sorted_leaf_count_ = tree_.leaves().size();
  sorted_extents_.EnsureDiscarding(sorted_leaf_count_);
  for (size_t leaf = 0; leaf < sorted_leaf_count_; ++leaf) sorted_extents_[leaf] = ExtentOf(leaf);
}

bool BoxTree::SortIsDue() const {
  return count_ > 0 && (debt_.Exceeds(kChecksPerSort * count_) || HasGrown());
}

// Leaves are counted, since in a sum one box that has flown far away would outweigh all others.
bool BoxTree::HasGrown() const {
  const size_t leaf_count = tree_.leaves().size();
  size_t grown = leaf_count - std::min(leaf_count, sorted_leaf_count_);
  for (size_t leaf = 0; leaf < leaf_count - grown; ++leaf) {
    if (ExtentOf(leaf) > 2 * sorted_extents_[leaf]) ++grown;
  }
  return grown * 8 > leaf_count;
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
