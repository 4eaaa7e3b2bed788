#include "engine_client/broad_phase/kd/kd_tree.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_boxes.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"

namespace sweepstake {
namespace {

// 18 ns for a split at 0.17 ns per check.
constexpr uint64_t kChecksPerSplit = 105;
// A split is spread over so many frames that each costs about a third more.
constexpr uint64_t kMostSplitFrames = 6;
constexpr uint64_t kSplitSpread = 3;
constexpr uint64_t kChecksPerPair = 8;  // what writing one costs
// Of the mean leaf, in powers of two. Finding the pairs in leaves of four times the volume costs
// more than splitting at once.
constexpr double kSpoilt = 2;
// Boxes out of place or gone, as a share of all, that are worth a split.
constexpr size_t kStrayShare = 16;
// And that are worth splitting at once.
constexpr size_t kUpheavalShare = 4;
// For a thread to be called, in leaves and in blocks of 16 leaves.
constexpr size_t kLeastLeaves = 128;
constexpr size_t kLeastBlocks = 4;

class KdTree final : public BroadPhase {
 public:
  explicit KdTree(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "KDTree"; }
  uint32_t version() const override { return 3; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return splitter_.native_bytes() + newcomers_.native_bytes() + order_.capacity_bytes() +
           sorted_.native_bytes() + tree_.native_bytes() + parts_.native_bytes();
  }

 private:
  void TakeCount(std::span<const Aabb> boxes);
  void Remove(size_t count);
  void Add(std::span<const Aabb> boxes, size_t first);
  void ReserveSlots(size_t count);
  void Refresh(std::span<const Aabb> boxes);
  double MeanLeafSize() const;
  bool SplitIsDue() const;
  void BeginSplit();
  void Adopt(std::span<const Aabb> boxes);
  void SplitAtOnce(std::span<const Aabb> boxes);
  uint64_t SplitFrames() const;
  void CountCost(uint64_t pair_count);

  Executor* const executor_;
  KdOrder splitter_;
  KdOrder newcomers_;
  // Boxes by slot: those of the latest split with holes where some have gone, and from stray_begin_
  // on those that have come since.
  AlignedBuffer<uint32_t> order_;
  size_t slot_count_ = 0;
  size_t stray_begin_ = 0;
  size_t removed_count_ = 0;  // since the latest split
  size_t box_count_ = 0;
  LeafBoxes sorted_;
  LeafTree tree_;
  PairParts parts_;
  // A split under way, and the fewest boxes there have been since it began: what it says of others
  // is of boxes that have gone.
  bool splitting_ = false;
  bool split_done_ = false;
  size_t lasting_count_ = 0;
  double fresh_leaf_size_ = 0;  // after the latest split
  uint64_t fewest_checks_ = 0;  // in a frame since the latest split, per 256 boxes
  uint64_t excess_checks_ = 0;  // above that, since the latest split
  uint64_t latest_cost_ = 0;    // of a search, in checks per box
  uint64_t checks_ = 0;
};

void KdTree::Build(std::span<const Aabb> boxes) {
  box_count_ = slot_count_ = stray_begin_ = boxes.size();
  ReserveSlots(box_count_);
  std::iota(order_.data(), order_.data() + box_count_, 0U);
  Refresh(boxes);
  SplitAtOnce(boxes);
}

void KdTree::Update(std::span<const Aabb> boxes) {
  if (boxes.size() != box_count_) TakeCount(boxes);
  const bool adopts = split_done_;
  if (adopts) Adopt(boxes);
  Refresh(boxes);
  const double leaf_size = MeanLeafSize();
  if (adopts) {
    fresh_leaf_size_ = leaf_size;
  } else if (leaf_size > fresh_leaf_size_ + kSpoilt ||
             removed_count_ + slot_count_ - stray_begin_ > slot_count_ / kUpheavalShare) {
    SplitAtOnce(boxes);
  } else if (!splitting_ && SplitIsDue()) {
    SplitFrames() == 1 ? SplitAtOnce(boxes) : BeginSplit();
  }
}

uint64_t KdTree::SplitFrames() const {
  return std::clamp(kSplitSpread * kChecksPerSplit / (latest_cost_ + 1), uint64_t{1},
                    kMostSplitFrames);
}

void KdTree::TakeCount(std::span<const Aabb> boxes) {
  const size_t before = box_count_;
  box_count_ = boxes.size();
  if (box_count_ < before) {
    Remove(box_count_);
  } else {
    Add(boxes, before);
  }
}

// What is not below `count`.
void KdTree::Remove(size_t count) {
  for (size_t slot = 0; slot < slot_count_; ++slot) {
    if (order_[slot] == KdOrder::kHole || order_[slot] < count) continue;
    order_[slot] = KdOrder::kHole;
    ++removed_count_;
  }
  lasting_count_ = std::min(lasting_count_, count);
}

// The boxes from `first` on, into leaves of their own, which they share with those that have come
// before them since the latest split.
void KdTree::Add(std::span<const Aabb> boxes, size_t first) {
  uint32_t* const strays = order_.data() + stray_begin_;
  const size_t old_count = static_cast<size_t>(
      std::remove(strays, order_.data() + slot_count_, KdOrder::kHole) - strays);
  const size_t count = old_count + boxes.size() - first;
  const size_t aligned = (stray_begin_ + LeafTree::kWidth - 1) & ~(LeafTree::kWidth - 1);
  slot_count_ = aligned + count;
  order_.EnsureKeeping(slot_count_, stray_begin_ + old_count);
  uint32_t* const from = order_.data() + stray_begin_;
  std::copy_backward(from, from + old_count, order_.data() + aligned + old_count);
  std::fill(from, order_.data() + aligned, KdOrder::kHole);
  const std::span<uint32_t> all(order_.data() + aligned, count);
  std::iota(all.begin() + static_cast<ptrdiff_t>(old_count), all.end(),
            static_cast<uint32_t>(first));
  newcomers_.Sort(boxes, all);
  stray_begin_ = aligned;
}

// For this many boxes, however many holes a split makes.
void KdTree::ReserveSlots(size_t count) {
  const size_t slots = KdOrder::MostSlots(count);
  order_.EnsureDiscarding(slots);
  sorted_.Resize(slots);
  tree_.LayOut(slots);
}

void KdTree::Refresh(std::span<const Aabb> boxes) {
  checks_ = 0;
  sorted_.Resize(slot_count_);
  tree_.LayOut(slot_count_);
  if (slot_count_ == 0) return;
  const std::span<const uint32_t> order(order_.data(), slot_count_);
  const size_t part_count = PartCount(executor_, tree_.leaf_count(), kLeastLeaves);
  RunParts(executor_, part_count, [&](size_t part) {
    const PartRange leaves = RangeOfPart(tree_.leaf_count(), part, part_count, 1);
    sorted_.GatherLeaves(boxes, order, leaves.begin, leaves.end, tree_.level(0));
  });
  tree_.RefitNodes();
}

// The logarithm of the volume of the leaves, on the whole: what the sum of their extents says a few
// long ones would decide.
double KdTree::MeanLeafSize() const {
  if (tree_.leaf_count() == 0) return 0;
  const LeafTree::Level& leaves = tree_.level(0);
  int64_t sum = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t leaf = 0; leaf < leaves.count; ++leaf) {
      const float extent = std::max(leaves.max[axis][leaf] - leaves.min[axis][leaf], 0.0F);
      sum += std::bit_cast<int32_t>(extent) >> 23;  // its exponent
    }
  }
  return static_cast<double>(sum) / static_cast<double>(leaves.count);
}

bool KdTree::SplitIsDue() const {
  return excess_checks_ > kChecksPerSplit * 256 ||
         removed_count_ + slot_count_ - stray_begin_ > slot_count_ / kStrayShare;
}

void KdTree::BeginSplit() {
  splitter_.Begin(sorted_.Groups(), box_count_);
  lasting_count_ = box_count_;
  splitting_ = true;
}

void KdTree::Adopt(std::span<const Aabb> boxes) {
  ReserveSlots(box_count_);
  slot_count_ = stray_begin_ = splitter_.slot_count();
  splitter_.TakeSlots({order_.data(), slot_count_});
  splitting_ = split_done_ = false;
  removed_count_ = 0;
  fewest_checks_ = std::numeric_limits<uint64_t>::max();
  excess_checks_ = 0;
  if (lasting_count_ < box_count_ || splitter_.box_count() > lasting_count_) {
    Remove(lasting_count_);
    Add(boxes, lasting_count_);
  }
}

void KdTree::SplitAtOnce(std::span<const Aabb> boxes) {
  BeginSplit();
  splitter_.Finish(executor_);
  Adopt(boxes);
  Refresh(boxes);
  fresh_leaf_size_ = MeanLeafSize();
}

void KdTree::FindPairs(PairBuffer& out) {
  const size_t before = out.size();
  // The step of a split is the first item: it reads nothing that the others do.
  const size_t steps = splitting_ && !split_done_ ? 1 : 0;
  checks_ = parts_.Run(executor_, tree_.block_count() + steps, kLeastBlocks, 1, out,
                       [&](size_t begin, size_t end, PairBuffer& pairs) {
                         if (begin < steps)
                           split_done_ = splitter_.Advance(splitter_.work() / SplitFrames() + 1);
                         return tree_.FindPairs(sorted_.blocks(), std::max(begin, steps) - steps,
                                                end - steps, pairs);
                       });
  CountCost(out.size() - before);
}

void KdTree::CountCost(uint64_t pair_count) {
  const uint64_t box_count = std::max<size_t>(box_count_, 1);
  const uint64_t checks = checks_ * 256 / box_count;
  fewest_checks_ = std::min(fewest_checks_, checks);
  excess_checks_ += checks - fewest_checks_;
  latest_cost_ = (checks_ + kChecksPerPair * pair_count) / box_count;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeKdTree(const BroadPhaseOptions& options) {
  return std::make_unique<KdTree>(options);
}

}  // namespace sweepstake
