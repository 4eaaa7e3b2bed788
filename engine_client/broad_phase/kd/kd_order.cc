#include "engine_client/broad_phase/kd/kd_order.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/kd/kd_centers.h"
#include "engine_client/broad_phase/kd/size_classes.h"

namespace sweepstake {
namespace {

// Up to here all splits of a range are one step: its centers stay in the cache.
constexpr size_t kWholeRange = 4096;

constexpr size_t RoundUp(size_t count) {
  return (count + KdRange::kPart - 1) / KdRange::kPart * KdRange::kPart;
}

// How often each center of a range is moved until the parts are small enough.
size_t SplitDepth(size_t count) {
  size_t depth = 0;
  for (; count > KdRange::kPart; count = (count + 1) / 2) ++depth;
  return depth;
}

KdRange MakeRange(size_t begin, size_t end, const double* extent_sums, double negligible) {
  KdRange range{begin, end, {}};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double mean = extent_sums[axis] / static_cast<double>(end - begin);
    const double least = double{std::numeric_limits<float>::min()};
    range.axis_weight[axis] = static_cast<float>(1 / (mean + negligible + least));
  }
  return range;
}

}  // namespace

void KdOrder::Reserve(size_t count) {
  // Gaps behind the classes, and a register to read past the last.
  capacity_ = RoundUp(MostSlots(count)) + kPart;
  floats_.EnsureDiscarding(6 * capacity_);
  words_.EnsureDiscarding(3 * capacity_);
  for (size_t k = 0; k < 2; ++k) {
    for (size_t axis = 0; axis < 3; ++axis) {
      columns_[k].center[axis] = floats_.data() + (3 * k + axis) * capacity_;
    }
    columns_[k].box = words_.data() + k * capacity_;
  }
  result_ = words_.data() + 2 * capacity_;
  waiting_ = run_count_ = present_count_ = absent_count_ = 0;
}

// Those that do not take part, holes excepted, from the end of the result downwards.
void KdOrder::CollectAbsent(const BoxGroups& groups, size_t box_count) {
  if (present_count_ == box_count) return;
  for (size_t group = 0; group < groups.count; ++group) {
    for (size_t lane = 0; lane < BoxGroups::kWidth; ++lane) {
      const size_t at = group * groups.stride + lane;
      if (groups.min[0][at] <= groups.max[0][at] || groups.id[at] == kHole) continue;
      if (present_count_ + absent_count_ == box_count) return;  // behind the last box
      result_[capacity_ - ++absent_count_] = groups.id[at];
    }
  }
}

void KdOrder::PushRun(const KdRange& range, size_t columns) {
  runs_[run_count_++] = {range.begin, range.end};
  stack_[waiting_++] = {range, columns};
}

void KdOrder::FormRuns() {
  const float* const extents[3] = {columns_[1].center[0], columns_[1].center[1],
                                   columns_[1].center[2]};
  AxisSpread spreads[3];
  double negligible = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    spreads[axis] = SpreadOf(columns_[0].center[axis], extents[axis], present_count_);
    // A millionth of the world is no size that splits should heed.
    negligible = std::max(negligible, 1e-6 * (double{spreads[axis].greatest_center} -
                                              double{spreads[axis].least_center}));
  }
  const SizeClasses classes(spreads, extents, present_count_);
  if (classes.all_ordinary()) {
    const double sums[3] = {spreads[0].extent_sum, spreads[1].extent_sum, spreads[2].extent_sum};
    return PushRun(MakeRange(0, present_count_, sums, negligible), 0);
  }
  const std::span<uint32_t> of_slots(result_, present_count_);
  const auto counts = classes.ClassifyAll(extents, of_slots);
  MoveToClasses(of_slots, counts, negligible);
}

// Orders the boxes by class, from the first columns to the second, each class from a multiple of
// kPart on.
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

void KdOrder::Begin(const BoxGroups& groups, size_t box_count) {
  Reserve(box_count);
  present_count_ = CollectCenters(groups, columns_[0], columns_[1]);
  CollectAbsent(groups, box_count);
  StartSplitting();
}

void KdOrder::Begin(std::span<const Aabb> boxes) {
  Reserve(boxes.size());
  for (size_t index = 0; index < boxes.size(); ++index) {
    const Aabb& box = boxes[index];
    if (!TakesPart(box)) {
      result_[capacity_ - ++absent_count_] = static_cast<uint32_t>(index);
      continue;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      // Halves: the sum of two finite floats need not be finite.
      columns_[0].center[axis][present_count_] = box.min[axis] * 0.5F + box.max[axis] * 0.5F;
      columns_[1].center[axis][present_count_] = box.max[axis] - box.min[axis];
    }
    columns_[0].box[present_count_++] = static_cast<uint32_t>(index);
  }
  StartSplitting();
}

void KdOrder::StartSplitting() {
  whole_range_ = std::clamp(RoundUp(present_count_ / 32), size_t{64}, kWholeRange);
  if (present_count_ > 0) FormRuns();
}

size_t KdOrder::work() const { return present_count_ * SplitDepth(present_count_); }

void KdOrder::SplitWhole(const Waiting& waiting) {
  SplitAll(columns_[waiting.columns], columns_[1 - waiting.columns], waiting.range, result_);
}

// Splits once: the parts wait in the other columns.
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

void KdOrder::Finish(Executor* executor) {
  if (executor == nullptr || executor->thread_count() == 1 || present_count_ <= kWholeRange) {
    whole_range_ = kWholeRange;
    Advance(std::numeric_limits<size_t>::max());
    return;
  }
  // Halves until there are enough parts, then all of them at once.
  const size_t largest = std::max(present_count_ / (2 * executor->thread_count()), kWholeRange);
  size_t next = 0;
  while (next < waiting_) {
    if (stack_[next].range.count() <= largest) {
      ++next;
    } else {
      const Waiting waiting = stack_[next];
      stack_[next] = stack_[--waiting_];
      SplitTop(waiting);
    }
  }
  RunParts(executor, waiting_, [this](size_t part) { SplitWhole(stack_[part]); });
  waiting_ = 0;
}

size_t KdOrder::slot_count() const {
  const size_t end = run_count_ == 0 ? 0 : RoundUp(runs_[run_count_ - 1].end);
  return end + absent_count_;
}

void KdOrder::TakeSlots(std::span<uint32_t> slots) const {
  size_t at = 0;
  for (size_t k = 0; k < run_count_; ++k) {
    std::fill(slots.data() + at, slots.data() + runs_[k].begin, kHole);
    std::copy(result_ + runs_[k].begin, result_ + runs_[k].end, slots.data() + runs_[k].begin);
    at = runs_[k].end;
  }
  std::fill(slots.data() + at, slots.data() + slots.size() - absent_count_, kHole);
  std::copy_n(result_ + capacity_ - absent_count_, absent_count_,
              slots.data() + slots.size() - absent_count_);
}

void KdOrder::Sort(std::span<const Aabb> boxes, std::span<uint32_t> order) {
  boxes_.Gather(boxes, order);
  Begin(GroupsOf(boxes_.Lanes()), order.size());
  Finish(nullptr);
  uint32_t* to = order.data();
  for (size_t k = 0; k < run_count_; ++k) {
    to = std::copy(result_ + runs_[k].begin, result_ + runs_[k].end, to);
  }
  std::copy_n(result_ + capacity_ - absent_count_, absent_count_, to);
}

}  // namespace sweepstake
