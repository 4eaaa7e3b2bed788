#include "engine_client/broad_phase/kd/kd_order.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/stop_poll.h"

namespace sweepstake {
namespace {

// The maximum size of a range that one step splits down to ranges of kPart boxes. The centers of
// such a range stay in the cache.
constexpr size_t kMaxWholeRange = 4096;
// The number of center moves between two polls of the stop request; they take about a millisecond.
constexpr size_t kMovesPerQuestion = size_t{1} << 19;

constexpr size_t RoundUp(size_t count) {
  return (count + KdRange::kPart - 1) / KdRange::kPart * KdRange::kPart;
}

// Returns the number of splits from a range of `count` boxes down to ranges of at most kPart boxes.
// Each split moves every center once.
size_t SplitDepth(size_t count) {
  size_t depth = 0;
  for (; count > KdRange::kPart; count = (count + 1) / 2) ++depth;
  return depth;
}

KdRange MakeRange(size_t begin, size_t end, const double* extent_sums, double negligible) {
  KdRange range{begin, end, {}};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double mean = extent_sums[axis] / static_cast<double>(end - begin);
    const double min_extent = double{std::numeric_limits<float>::min()};
    range.axis_weight[axis] = static_cast<float>(1 / (mean + negligible + min_extent));
  }
  return range;
}

}  // namespace

void KdOrder::Reserve(size_t count) {
  // Reserves slots for the gaps behind the classes, and a register behind the last slot.
  capacity_ = RoundUp(MaxSlots(count)) + kPart;
  floats_.EnsureDiscarding(6 * capacity_);
  words_.EnsureDiscarding(3 * capacity_);
  for (size_t k = 0; k < 2; ++k) {
    for (size_t axis = 0; axis < 3; ++axis) {
      columns_[k].center[axis] = floats_.data() + (3 * k + axis) * capacity_;
    }
    columns_[k].box = words_.data() + k * capacity_;
  }
  result_ = words_.data() + 2 * capacity_;
  waiting_ = run_count_ = valid_count_ = invalid_count_ = 0;
  run_parts_ = kPart;
}

void KdOrder::PushRun(const KdRange& range, size_t columns) {
  runs_[run_count_++] = {range.begin, range.end};
  stack_[waiting_] = {range, columns};
  stack_[waiting_++].range.run_parts = run_parts_;
}

void KdOrder::FormRuns() {
  const float* const extents[3] = {columns_[1].center[0], columns_[1].center[1],
                                   columns_[1].center[2]};
  AxisSpread spreads[3];
  double negligible = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    spreads[axis] = SpreadOf(columns_[0].center[axis], extents[axis], valid_count_);
    // Differences of extents below a millionth of the scene's size are ignored.
    negligible = std::max(
        negligible, 1e-6 * (double{spreads[axis].max_center} - double{spreads[axis].min_center}));
  }
  const SizeClasses classes(spreads, extents, valid_count_);
  if (classes.all_ordinary()) {
    const double sums[3] = {spreads[0].extent_sum, spreads[1].extent_sum, spreads[2].extent_sum};
    return PushRun(MakeRange(0, valid_count_, sums, negligible), 0);
  }
  const std::span<uint32_t> of_slots(result_, valid_count_);
  const auto counts = classes.ClassifyAll(extents, of_slots);
  MoveToClasses(of_slots, counts, negligible);
}

// Moves the boxes from the first set of columns to the second, class by class. Each class begins at
// a multiple of kPart.
void KdOrder::MoveToClasses(std::span<const uint32_t> of_slots,
                            std::span<const size_t, SizeClasses::kCount> counts,
                            double negligible) {
  size_t next[SizeClasses::kCount];
  double extent_sums[SizeClasses::kCount][3] = {};
  size_t begin = 0;
  for (size_t k = 0; k < SizeClasses::kCount; ++k) {
    next[k] = begin;
    begin += RoundUp(counts[k]);
  }
  for (size_t i = 0; i < of_slots.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      extent_sums[of_slots[i]][axis] += double{columns_[1].center[axis][i]};
    }
  }
  for (size_t i = 0; i < of_slots.size(); ++i) {
    const size_t slot = next[of_slots[i]]++;
    for (size_t axis = 0; axis < 3; ++axis) {
      columns_[1].center[axis][slot] = columns_[0].center[axis][i];
    }
    columns_[1].box[slot] = columns_[0].box[i];
  }
  for (size_t k = 0; k < SizeClasses::kCount; ++k) {
    if (counts[k] == 0) continue;
    PushRun(MakeRange(next[k] - counts[k], next[k], extent_sums[k], negligible), 1);
  }
}

// Inline: a call would take as long as the function's work.
inline void KdOrder::Collect(const Aabb& box, uint32_t index) {
  if (!IsValidFast(box)) {
    result_[capacity_ - ++invalid_count_] = index;
    return;
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    // The halves are added, since the sum of two floats may overflow.
    columns_[0].center[axis][valid_count_] = box.min[axis] * 0.5F + box.max[axis] * 0.5F;
    columns_[1].center[axis][valid_count_] = box.max[axis] - box.min[axis];
  }
  columns_[0].box[valid_count_++] = index;
}

void KdOrder::Begin(std::span<const Aabb> boxes) {
  Reserve(boxes.size());
  for (size_t index = 0; index < boxes.size(); ++index) {
    Collect(boxes[index], static_cast<uint32_t>(index));
  }
  StartSplitting();
}

void KdOrder::Begin(std::span<const LeafBlock> leaves, size_t box_count) {
  Reserve(box_count);
  valid_count_ = CollectCenters(leaves, columns_[0], columns_[1]);
  if (valid_count_ != box_count) CollectInvalid(leaves);
  StartSplitting();
}

void KdOrder::CollectInvalid(std::span<const LeafBlock> leaves) {
  for (const LeafBlock& leaf : leaves) {
    for (size_t lane = 0; lane < LeafBlock::kWidth; ++lane) {
      const bool is_valid = leaf.min[0][lane] <= leaf.max[0][lane];
      if (is_valid || leaf.id[lane] == kHole) continue;
      result_[capacity_ - ++invalid_count_] = leaf.id[lane];
    }
  }
}

void KdOrder::StartSplitting() {
  whole_range_ = std::clamp(RoundUp(valid_count_ / 32), size_t{64}, kMaxWholeRange);
  if (valid_count_ > 0) FormRuns();
}

size_t KdOrder::work() const { return valid_count_ * SplitDepth(valid_count_); }

void KdOrder::SplitWhole(const Waiting& waiting) {
  SplitAll(columns_[waiting.columns], columns_[1 - waiting.columns], waiting.range, result_);
}

// Splits the range once and pushes the two new ranges, which are now in the other set of columns.
void KdOrder::SplitTop(const Waiting& waiting) {
  SplitOnce(columns_[waiting.columns], columns_[1 - waiting.columns], waiting.range);
  Waiting first = waiting;
  Waiting second = waiting;
  first.columns = second.columns = 1 - waiting.columns;
  first.range.end = second.range.begin = KdSplitPoint(waiting.range);
  stack_[waiting_++] = first;
  stack_[waiting_++] = second;
}

bool KdOrder::Advance(size_t budget) {
  size_t spent = 0;
  while (waiting_ > 0 && spent < budget) {
    const Waiting next = stack_[--waiting_];
    const size_t count = next.range.count();
    if (count <= whole_range_) {
      SplitWhole(next);
      spent += count * SplitDepth(count);
    } else {
      SplitTop(next);
      spent += count;
    }
  }
  return waiting_ == 0;
}

bool KdOrder::Finish(Executor* executor, StopRequest* stop) {
  if (executor == nullptr || executor->thread_count() == 1 || valid_count_ <= kMaxWholeRange) {
    whole_range_ = kMaxWholeRange;
    while (!IsStopped(stop)) {
      if (Advance(kMovesPerQuestion)) return true;
    }
    return false;
  }
  // Splits ranges until there are enough for all threads. The threads then split these ranges in
  // parallel.
  const size_t max_part = std::max(valid_count_ / (2 * executor->thread_count()), kMaxWholeRange);
  size_t next = 0;
  while (next < waiting_ && !IsStopped(stop)) {
    if (stack_[next].range.count() <= max_part) {
      ++next;
    } else {
      const Waiting waiting = stack_[next];
      stack_[next] = stack_[--waiting_];
      SplitTop(waiting);
    }
  }
  RunParts(executor, waiting_, [&](size_t part) {
    if (!IsStopped(stop)) SplitWhole(stack_[part]);
  });
  waiting_ = 0;
  return !IsStopped(stop);
}

size_t KdOrder::slot_count() const {
  const size_t end = run_count_ == 0 ? 0 : RoundUp(runs_[run_count_ - 1].end);
  return end + invalid_count_;
}

void KdOrder::TakeSlots(std::span<uint32_t> slots) const {
  size_t at = 0;
  for (size_t k = 0; k < run_count_; ++k) {
    std::fill(slots.data() + at, slots.data() + runs_[k].begin, kHole);
    std::copy(result_ + runs_[k].begin, result_ + runs_[k].end, slots.data() + runs_[k].begin);
    at = runs_[k].end;
  }
  const std::span<uint32_t> last = slots.last(invalid_count_);
  std::fill(slots.data() + at, last.data(), kHole);
  const std::span<const uint32_t> invalid = InvalidBoxes();
  std::copy(invalid.begin(), invalid.end(), last.begin());
}

void KdOrder::TakeBoxes(std::span<uint32_t> order) const {
  uint32_t* to = order.data();
  for (size_t k = 0; k < run_count_; ++k) {
    to = std::copy(result_ + runs_[k].begin, result_ + runs_[k].end, to);
  }
  const std::span<const uint32_t> invalid = InvalidBoxes();
  std::copy(invalid.begin(), invalid.end(), to);
}

void KdOrder::Sort(std::span<const Aabb> boxes, std::span<uint32_t> order, StopRequest* stop,
                   size_t run_parts) {
  Reserve(order.size());
  run_parts_ = run_parts;
  for (const uint32_t index : order) Collect(boxes[index], index);
  StartSplitting();
  if (Finish(nullptr, stop)) TakeBoxes(order);
}

}  // namespace sweepstake
