#include "engine_client/broad_phase/sweep/sap.h"

#include <algorithm>
#include <utility>

#include "engine_client/broad_phase/common/byte_scan.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/radix_sort.h"

namespace sweepstake {
namespace {

// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinFilledPerPart = 2048;
constexpr size_t kMinSortedPerPart = 16384;

// The sweep axis is divided into equal intervals, the steps. A counting sort orders the boxes by
// their step. If a box shares its step with more boxes than this on average, an exact sort is
// cheaper. For each 64 boxes that share its step, the sweep compares one more register.
constexpr uint64_t kMaxBoxesSharingStep = 64;
// The mean number of boxes per step. Finer steps would cost the counting sort more than they save
// the sweep, because a box covers dozens of steps.
constexpr size_t kBoxesPerStep = 8;

class Sap final : public BroadPhase {
 public:
  explicit Sap(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "SAP"; }
  uint32_t version() const override { return 4; }
  void DoBuild(std::span<const Aabb> boxes) override { DoUpdate(boxes); }
  void DoUpdate(std::span<const Aabb> boxes) override;
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override;

 private:
  void CountSteps(std::span<const Aabb> boxes, size_t axis);
  bool CountSlots();
  void SortBySteps();
  void SortExactly(std::span<const Aabb> boxes, size_t axis);
  size_t step_count() const { return static_cast<size_t>(sweep_.last) + 1; }
  PartRange BoxesOfPart(size_t part) const {
    return RangeOfPart(boxes_.count(), part, part_count_, ByteBoxes::kGranule);
  }

  Executor* executor_;
  SweepAxis sweep_;
  size_t part_count_ = 1;           // the number of parts of a sort
  AlignedBuffer<uint32_t> steps_;   // the step of each box
  AlignedBuffer<uint32_t> starts_;  // per part and step: the box count, later the next free slot
  RadixSort sort_;
  ByteBoxes boxes_;
  PairParts parts_;
  uint64_t checks_ = 0;
};

void Sap::DoUpdate(std::span<const Aabb> boxes) {
  checks_ = 0;
  const CoordinateRange range = CoordinateRange::Sample(boxes);
  const auto axis = static_cast<size_t>(range.sweep_axis);
  const auto steps =
      static_cast<float>(std::clamp<size_t>(boxes.size() / kBoxesPerStep, 512, 65536));
  sweep_ = {false, range.low[axis], steps / range.width(range.sweep_axis), steps - 1};
  boxes_.Resize(boxes.size(), true);
  part_count_ = PartCount(executor_, boxes.size(), kMinSortedPerPart);
  CountSteps(boxes, axis);
  if (IsStopped(stop())) return;
  sweep_.exact = !CountSlots();
  sweep_.exact ? SortExactly(boxes, axis) : SortBySteps();
  if (IsStopped(stop())) return;
  const size_t fill_parts = PartCount(executor_, boxes.size(), kMinFilledPerPart);
  RunParts(executor_, fill_parts, [&](size_t part) {
    const PartRange slots = RangeOfPart(boxes.size(), part, fill_parts, ByteBoxes::kGranule);
    ForEachBlock(stop(), slots.begin, slots.end,
                 [&](size_t from, size_t to) { boxes_.Fill(boxes, range, sweep_, from, to); });
  });
}

// Counts the boxes of each step. Invalid boxes belong to the last step.
void Sap::CountSteps(std::span<const Aabb> boxes, size_t axis) {
  steps_.EnsureDiscarding(boxes.size());
  starts_.EnsureDiscarding(part_count_ * step_count());
  RunParts(executor_, part_count_, [&](size_t part) {
    uint32_t* const counts = starts_.data() + part * step_count();
    std::fill_n(counts, step_count(), 0U);
    const SweepAxis sweep = sweep_;
    const PartRange range = BoxesOfPart(part);
    ForEachBlock(stop(), range.begin, range.end, [&](size_t from, size_t to) {
      for (size_t i = from; i < to; ++i) {
        const Aabb& box = boxes[i];
        const uint32_t step = sweep.Step(IsValidFast(box) ? box.min[axis] : kInfinity);
        steps_[i] = step;
        ++counts[step];
      }
    });
  });
}

// Replaces the counts by the first slots of each part and step. Returns false if too many boxes
// share a step.
bool Sap::CountSlots() {
  uint64_t neighbours = 0;
  uint32_t sum = 0;
  for (size_t step = 0; step < step_count(); ++step) {
    const uint64_t before = sum;
    for (size_t part = 0; part < part_count_; ++part)
      sum += std::exchange(starts_[part * step_count() + step], sum);
    neighbours += (sum - before) * (sum - before);
  }
  return neighbours <= kMaxBoxesSharingStep * boxes_.count();
}

// Sorts the boxes by steps. Boxes of one step are in the order of their ids, for any number of
// parts.
void Sap::SortBySteps() {
  RunParts(executor_, part_count_, [&](size_t part) {
    uint32_t* const starts = starts_.data() + part * step_count();
    uint32_t* const ids = boxes_.ids();
    const PartRange range = BoxesOfPart(part);
    ForEachBlock(stop(), range.begin, range.end, [&](size_t from, size_t to) {
      for (size_t i = from; i < to; ++i) ids[starts[steps_[i]]++] = static_cast<uint32_t>(i);
    });
  });
}

void Sap::SortExactly(std::span<const Aabb> boxes, size_t axis) {
  const std::span<uint64_t> items = sort_.Items(boxes.size());
  const bool is_loaded = ForEachBlock(stop(), 0, boxes.size(), [&](size_t from, size_t to) {
    for (size_t i = from; i < to; ++i) {
      const float position = IsValidFast(boxes[i]) ? boxes[i].min[axis] : kInfinity;
      items[i] = PackSortItem(SortableKey(position), static_cast<uint32_t>(i));
    }
  });
  if (!is_loaded) return;
  const std::span<const uint64_t> sorted = sort_.Sort(stop());
  std::transform(sorted.begin(), sorted.end(), boxes_.ids(), SortItemPayload);
}

void Sap::DoFindPairs(PairBuffer& out) {
  const ByteLanes lanes = boxes_.Lanes();
  checks_ = parts_.Run(
      executor_, lanes.count, kMinSweptPerPart, kRowsPerTile, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        return FindPairsOfSwept(lanes, begin, end, pairs, stop());
      },
      stop());
}

size_t Sap::native_bytes() const {
  return steps_.capacity_bytes() + starts_.capacity_bytes() + sort_.native_bytes() +
         boxes_.native_bytes() + parts_.native_bytes();
}

}  // namespace

std::unique_ptr<BroadPhase> MakeSap(const BroadPhaseOptions& options) {
  return std::make_unique<Sap>(options);
}

}  // namespace sweepstake
