#include "engine_client/broad_phase/kd/kd_tree.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/rebuild_debt.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"

namespace sweepstake {
namespace {

// The cost of a split of all boxes, in checks per box. It is used for every instruction set. A
// value a third lower or a half higher changes the mean frame time of six scenes by at most 1 %
// (AVX-512, AVX2 and SSE4 on AMD Zen 4, `sweepstake-lab bench`). With a lower value, the slowest
// frames take longer.
constexpr uint64_t kChecksPerSplit = 105;
// Extra checks (the debt) are counted per 256 boxes, so that whole numbers are precise enough.
constexpr uint64_t kDebtScale = 256;
// The maximum growth of the leaves' mean volume, in powers of two. Beyond it, finding the pairs
// costs more than splitting at once.
constexpr double kMaxLeafGrowth = 2;
// A split is due if more than 1 in 16 slots holds an unsorted box or a hole. It is made at once if
// more than 1 in 4 slots does.
constexpr size_t kSlotsPerUnsorted = 16;
constexpr size_t kSlotsPerUnsortedAtOnce = 4;
// The minimum number of blocks of 16 leaves per part. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinBlocksPerPart = 4;

class KdTree final : public BroadPhase {
 public:
  explicit KdTree(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "KDTree"; }
  uint32_t version() const override { return 6; }
  void DoBuild(std::span<const Aabb> boxes) override;
  void DoUpdate(std::span<const Aabb> boxes) override;
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return splitter_.native_bytes() + unsorted_sorter_.native_bytes() + order_.capacity_bytes() +
           tree_.native_bytes() + parts_.native_bytes();
  }

 private:
  void Resize(std::span<const Aabb> boxes);
  void Remove(size_t count);
  void Add(std::span<const Aabb> boxes, size_t first);
  void ReserveSlots(size_t count);
  void Refit(std::span<const Aabb> boxes);
  double MeanLeafSize() const;
  size_t UnsortedCount() const { return removed_count_ + slot_count_ - unsorted_begin_; }
  bool SplitIsDue() const;
  bool SplitIsUrgent() const;
  void BeginSplit();
  void AdoptSplit(std::span<const Aabb> boxes);
  void SplitAtOnce(std::span<const Aabb> boxes);
  uint64_t SplitFrames() const { return RebuildFrames(kChecksPerSplit, latest_cost_); }
  void RecordCost(uint64_t pair_count);

  Executor* const executor_;
  KdOrder splitter_;
  KdOrder unsorted_sorter_;
  // The id of the box in each slot. The slots up to unsorted_begin_ are in the order of the latest
  // split; holes mark removed boxes. Behind them are the unsorted boxes. These were added after the
  // latest split and have an order of their own.
  AlignedBuffer<uint32_t> order_;
  size_t slot_count_ = 0;
  size_t unsorted_begin_ = 0;
  size_t removed_count_ = 0;  // the number of boxes removed since the latest split
  size_t box_count_ = 0;
  LeafTree tree_;
  PairParts parts_;
  bool is_splitting_ = false;
  bool split_is_done_ = false;
  // The lowest number of boxes since the split in progress began. Boxes from this index on were
  // removed, and possibly added again as other objects, so that their places in the split are
  // invalid.
  size_t lasting_count_ = 0;
  double fresh_leaf_size_ = 0;  // the mean leaf size after the latest split
  RebuildDebt debt_;            // extra checks since the latest split, per kDebtScale boxes
  uint64_t latest_cost_ = 0;    // the cost of the latest search, in checks per box
  uint64_t checks_ = 0;
};

void KdTree::DoBuild(std::span<const Aabb> boxes) {
  box_count_ = slot_count_ = unsorted_begin_ = boxes.size();
  ReserveSlots(box_count_);
  std::iota(order_.data(), order_.data() + box_count_, 0U);
  Refit(boxes);
  SplitAtOnce(boxes);
}

void KdTree::DoUpdate(std::span<const Aabb> boxes) {
  if (boxes.size() != box_count_) Resize(boxes);
  if (split_is_done_) {
    AdoptSplit(boxes);
    Refit(boxes);
    fresh_leaf_size_ = MeanLeafSize();
    return;
  }
  Refit(boxes);
  if (SplitIsUrgent()) {
    SplitAtOnce(boxes);
  } else if (!is_splitting_ && SplitIsDue()) {
    SplitFrames() == 1 ? SplitAtOnce(boxes) : BeginSplit();
  }
}

void KdTree::Resize(std::span<const Aabb> boxes) {
  const size_t old_count = box_count_;
  box_count_ = boxes.size();
  if (box_count_ < old_count) {
    Remove(box_count_);
  } else {
    Add(boxes, old_count);
  }
}

// Replaces all boxes with index `count` or higher by holes.
void KdTree::Remove(size_t count) {
  for (size_t slot = 0; slot < slot_count_; ++slot) {
    if (order_[slot] == KdOrder::kHole || order_[slot] < count) continue;
    order_[slot] = KdOrder::kHole;
    ++removed_count_;
  }
  lasting_count_ = std::min(lasting_count_, count);
}

// Adds the boxes from index `first` on to the unsorted boxes, then sorts all unsorted boxes again.
void KdTree::Add(std::span<const Aabb> boxes, size_t first) {
  // Closes the holes between the remaining unsorted boxes, and moves these boxes to the start of a
  // leaf.
  uint32_t* const unsorted = order_.data() + unsorted_begin_;
  const size_t old_count = static_cast<size_t>(
      std::remove(unsorted, order_.data() + slot_count_, KdOrder::kHole) - unsorted);
  const size_t count = old_count + boxes.size() - first;
  const size_t aligned = (unsorted_begin_ + LeafTree::kWidth - 1) & ~(LeafTree::kWidth - 1);
  slot_count_ = aligned + count;
  order_.EnsureKeeping(slot_count_, unsorted_begin_ + old_count);
  uint32_t* const from = order_.data() + unsorted_begin_;
  std::copy_backward(from, from + old_count, order_.data() + aligned + old_count);
  std::fill(from, order_.data() + aligned, KdOrder::kHole);
  // Appends the new boxes.
  const std::span<uint32_t> all(order_.data() + aligned, count);
  std::iota(all.begin() + static_cast<ptrdiff_t>(old_count), all.end(),
            static_cast<uint32_t>(first));
  unsorted_sorter_.Sort(boxes, all, stop());
  unsorted_begin_ = aligned;
}

// Makes room for `count` boxes and for any number of holes that a split can leave.
void KdTree::ReserveSlots(size_t count) {
  const size_t slots = KdOrder::MaxSlots(count);
  order_.EnsureDiscarding(slots);
  tree_.Reserve(slots);
}

void KdTree::Refit(std::span<const Aabb> boxes) {
  checks_ = 0;
  tree_.Refit(boxes, {order_.data(), slot_count_}, executor_, stop());
}

// Returns the mean of the base-2 logarithms, rounded, of the leaves' volumes. A sum of extents
// would depend mostly on a few long leaves.
double KdTree::MeanLeafSize() const {
  const LeafTree::View& tree = tree_.view();
  if (tree.top == 0) return 0;
  const BoxLanes& leaves = tree.levels[1];
  int64_t sum = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t leaf = 0; leaf < leaves.count; ++leaf) {
      const float extent = std::max(leaves.max[axis][leaf] - leaves.min[axis][leaf], 0.0F);
      sum += std::bit_cast<int32_t>(extent) >> 23;  // the exponent of the extent
    }
  }
  return static_cast<double>(sum) / static_cast<double>(leaves.count);
}

bool KdTree::SplitIsDue() const {
  return debt_.Exceeds(kChecksPerSplit * kDebtScale) ||
         UnsortedCount() > slot_count_ / kSlotsPerUnsorted;
}

bool KdTree::SplitIsUrgent() const {
  return MeanLeafSize() > fresh_leaf_size_ + kMaxLeafGrowth ||
         UnsortedCount() > slot_count_ / kSlotsPerUnsortedAtOnce;
}

void KdTree::BeginSplit() {
  splitter_.Begin(tree_.leaves(), box_count_);
  lasting_count_ = box_count_;
  is_splitting_ = true;
}

// Replaces the order by the result of the completed split. Boxes that were added while the split
// was in progress become unsorted boxes.
void KdTree::AdoptSplit(std::span<const Aabb> boxes) {
  ReserveSlots(box_count_);
  slot_count_ = unsorted_begin_ = splitter_.slot_count();
  splitter_.TakeSlots({order_.data(), slot_count_});
  is_splitting_ = split_is_done_ = false;
  removed_count_ = 0;
  debt_.Clear();
  if (lasting_count_ < box_count_ || splitter_.box_count() > lasting_count_) {
    Remove(lasting_count_);
    Add(boxes, lasting_count_);
  }
}

void KdTree::SplitAtOnce(std::span<const Aabb> boxes) {
  if (IsStopped(stop())) return;
  BeginSplit();
  if (!splitter_.Finish(executor_, stop())) return;
  AdoptSplit(boxes);
  if (IsStopped(stop())) return;
  Refit(boxes);
  fresh_leaf_size_ = MeanLeafSize();
}

// The search itself is LeafTree::FindPairs (kd_search.cc). If a split is in progress, its next step
// is the first item of the parallel loop. It reads nothing that the search writes.
void KdTree::DoFindPairs(PairBuffer& out) {
  const size_t before = out.size();
  const size_t steps = is_splitting_ && !split_is_done_ ? 1 : 0;
  checks_ = parts_.Run(
      executor_, tree_.block_count() + steps, kMinBlocksPerPart, 1, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        if (begin < steps) split_is_done_ = splitter_.Advance(splitter_.work() / SplitFrames() + 1);
        return tree_.FindPairs(std::max(begin, steps) - steps, end - steps, pairs, stop());
      },
      stop());
  RecordCost(out.size() - before);
}

void KdTree::RecordCost(uint64_t pair_count) {
  const uint64_t box_count = std::max<size_t>(box_count_, 1);
  debt_.AddSearch(checks_ * kDebtScale / box_count);
  latest_cost_ = SearchCost(checks_, pair_count) / box_count;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeKdTree(const BroadPhaseOptions& options) {
  return std::make_unique<KdTree>(options);
}

}  // namespace sweepstake
