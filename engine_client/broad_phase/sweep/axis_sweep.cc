#include "engine_client/broad_phase/sweep/axis_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/byte_scan.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/sweep/sorted_endpoints.h"
#include "engine_client/broad_phase/sweep/sorted_pairs.h"

namespace sweepstake {
namespace {

// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinBoxesPerPart = 2048;

// The pairs are kept between frames up to this mean number of pairs per box.
constexpr size_t kMaxPairsPerBox = 32;
// A repair restores the sorted orders by insertion. If it exceeds its budget of swaps, its work is
// lost, and no repair is tried in this number of frames.
constexpr int kPauseFrames = 8;
// After a sort by steps, the faces within each step are unsorted, and the next repair must sort
// them too. Its budget is increased by this number of swaps per face.
constexpr size_t kSwapsPerFace = 8;
// The size of the sample from which the motion is estimated.
constexpr size_t kMotionSample = 64;

// The time of one swap, and the time per box for sorting all faces again and filling the sweep's
// lanes (ByteLanes). Measured on AMD Zen 5 (`sweepstake-lab bench`). Both are used for every
// instruction set, since most of that code has no vectors.
constexpr double kSwapNs = 5;
constexpr double kSortNs = 30;

// Returns the number of swaps up to which a repair is cheaper than a new sort and a sweep.
double SwapBudget(uint64_t sweep_checks, size_t box_count) {
  return (kSortNs * static_cast<double>(box_count) +
          SweptCheckNs() * static_cast<double>(sweep_checks)) /
         kSwapNs;
}

bool OverlapOn(const BoxRecord& a, const BoxRecord& b, size_t axis) {
  return a.min[axis] <= b.max[axis] && b.min[axis] <= a.max[axis];
}

class AxisSweep final : public BroadPhase {
 public:
  explicit AxisSweep(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "AxisSweep"; }
  uint32_t version() const override { return 5; }
  void DoBuild(std::span<const Aabb> boxes) override;
  void DoUpdate(std::span<const Aabb> boxes) override;
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override;

 private:
  std::span<const BoxRecord> records() const { return {records_.data(), count_}; }
  size_t BoxParts() const { return PartCount(executor_, count_, kMinBoxesPerPart); }
  void LoadBoxes(std::span<const Aabb> boxes);
  bool ChangeCount(std::span<const Aabb> boxes);
  double ExpectedSwaps(std::span<const Aabb> boxes) const;
  bool RepairOrders(std::span<const Aabb> boxes);
  void CollectMoved(std::span<const Aabb> boxes);
  bool RepairAxis(std::span<const Aabb> boxes, size_t axis, SwapAllowance& allowance);
  SweepAxis StepsOn(size_t axis) const;
  void SortAxis(size_t axis, size_t room);
  void SortAll();
  void SetSweepOrder();
  void FillLanes(size_t part, size_t part_count);
  void PrepareSweep();
  void CopyPairs(PairBuffer& out) const;

  Executor* executor_;
  AlignedBuffer<BoxRecord> records_;  // the latest boxes by id, then one kInvalidRecord
  std::array<SortedEndpoints, 3> axes_{SortedEndpoints(0), SortedEndpoints(1), SortedEndpoints(2)};
  std::array<EndpointRoom, 2> rooms_;  // one set of buffers per sorting thread
  CoordinateRange range_;
  ByteBoxes swept_;
  PairParts parts_;
  SortedPairs pairs_;
  MovedBoxes moved_;
  AlignedBuffer<uint32_t> moved_ids_;  // the ids that FindMoved lists, with its bit kBecameInvalid
  size_t count_ = 0;
  bool pairs_known_ = false;  // whether pairs_ holds the pairs of the latest boxes
  bool calm_ = false;         // whether the pairs of the next sweep will be kept
  int pause_frames_ = 0;
  uint64_t checks_ = 0;
  uint64_t sweep_checks_ = 0;  // the checks of the latest sweep
};

void AxisSweep::DoBuild(std::span<const Aabb> boxes) {
  count_ = boxes.size();
  checks_ = 0;
  calm_ = false;
  pause_frames_ = 0;
  sweep_checks_ = 0;
  LoadBoxes(boxes);
  SortAll();
}

void AxisSweep::DoUpdate(std::span<const Aabb> boxes) {
  checks_ = 0;
  const bool in_order = ChangeCount(boxes);
  calm_ =
      in_order && pause_frames_ == 0 && ExpectedSwaps(boxes) <= SwapBudget(sweep_checks_, count_);
  pause_frames_ = std::max(0, pause_frames_ - 1);
  if (calm_ && RepairOrders(boxes)) {
    if (!pairs_known_) PrepareSweep();
    return;
  }
  if (IsStopped(stop())) return;
  if (calm_) pause_frames_ = kPauseFrames;
  calm_ = false;
  LoadBoxes(boxes);
  SortAll();
}

void AxisSweep::DoFindPairs(PairBuffer& out) {
  if (pairs_known_) return CopyPairs(out);
  const size_t before = out.size();
  const ByteLanes lanes = swept_.Lanes();
  sweep_checks_ = parts_.Run(
      executor_, lanes.count, kMinSweptPerPart, kRowsPerTile, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        return FindPairsOfSwept(lanes, begin, end, pairs, stop());
      },
      stop());
  checks_ += sweep_checks_;
  const auto found = out.pairs().subspan(before);
  pairs_known_ = calm_ && found.size() <= kMaxPairsPerBox * count_;
  if (pairs_known_) pairs_.Adopt(found, count_, stop());
}

size_t AxisSweep::native_bytes() const {
  size_t bytes = records_.capacity_bytes() + swept_.native_bytes() + parts_.native_bytes() +
                 pairs_.native_bytes() + moved_.native_bytes() + moved_ids_.capacity_bytes();
  for (const SortedEndpoints& axis : axes_) bytes += axis.native_bytes();
  for (const EndpointRoom& room : rooms_) bytes += room.native_bytes();
  return bytes;
}

void AxisSweep::LoadBoxes(std::span<const Aabb> boxes) {
  range_ = CoordinateRange::Sample(boxes);
  records_.EnsureDiscarding(count_ + 1);
  // Allocates the memory for repairs now, so that no later frame allocates.
  moved_ids_.EnsureDiscarding(count_);
  moved_.Clear(count_);
  const size_t part_count = BoxParts();
  RunParts(executor_, part_count, [&](size_t part) {
    const PartRange range = RangeOfPart(count_, part, part_count, ByteBoxes::kGranule);
    ForEachBlock(stop(), range.begin, range.end, [&](size_t from, size_t to) {
      StoreRecords(boxes.subspan(from, to - from), records_.data() + from);
    });
  });
  records_[count_] = kInvalidRecord;
}

// Adds or removes faces if the number of boxes has changed. Returns false if a new sort is cheaper
// or if stopped.
bool AxisSweep::ChangeCount(std::span<const Aabb> boxes) {
  const size_t before = count_;
  count_ = boxes.size();
  if (count_ == before) return true;
  if (count_ > before + before / 8) return false;
  if (count_ > before) pairs_known_ = false;
  records_.EnsureKeeping(count_ + 1, std::min(before, count_));
  for (size_t i = before; i < count_; ++i) records_[i] = RecordOf(boxes[i]);
  records_[count_] = kInvalidRecord;
  pairs_.Truncate(count_);
  for (SortedEndpoints& axis : axes_) {
    if (IsStopped(stop())) return false;
    axis.Truncate(count_);
    if (count_ > before) axis.Append(records(), before, rooms_[0]);
  }
  return true;
}

// Returns the expected number of swaps of a repair, estimated from the motion of a few boxes.
double AxisSweep::ExpectedSwaps(std::span<const Aabb> boxes) const {
  if (count_ == 0) return 0;
  const size_t stride = count_ / kMotionSample + 1;
  double swaps = 0;
  size_t sampled = 0;
  double density[3];
  for (size_t axis = 0; axis < 3; ++axis) density[axis] = axes_[axis].Density(records());
  for (size_t i = 0; i < count_; i += stride, ++sampled) {
    if (!IsValidFast(boxes[i]) || RecordOf(boxes[i]) == records_[i]) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double distance = std::abs(double{boxes[i].min[axis]} - records_[i].min[axis]) +
                              std::abs(double{boxes[i].max[axis]} - records_[i].max[axis]);
      swaps += std::min(distance * density[axis], 2.0 * static_cast<double>(count_));
    }
  }
  return swaps / static_cast<double>(sampled) * static_cast<double>(count_);
}

// Updates orders and pairs axis by axis. Until the last axis is done, the records mix coordinates
// of the old and the new frame. Orders and pairs are correct for these mixed boxes too: a pair
// begins or ends by a swap on one axis while it overlaps on the other two. Returns false if the
// budget is exceeded or if stopped; orders and pairs are then undefined.
bool AxisSweep::RepairOrders(std::span<const Aabb> boxes) {
  CollectMoved(boxes);
  const bool exact = axes_[0].is_exact() && axes_[1].is_exact() && axes_[2].is_exact();
  if (moved_.count() == 0 && exact) return true;
  if (!pairs_known_) range_ = CoordinateRange::Sample(boxes);
  auto budget = static_cast<size_t>(SwapBudget(sweep_checks_, count_));
  if (!exact) budget += kSwapsPerFace * 6 * count_;
  SwapAllowance allowance(budget, stop());
  for (size_t axis = 0; axis < 3; ++axis) {
    if (!IsStopped(stop()) && RepairAxis(boxes, axis, allowance)) continue;
    pairs_.ClearTouched();
    return false;
  }
  if (!pairs_known_) return true;
  pairs_.Settle([this](uint32_t a, uint32_t b) { return Overlap(records_[a], records_[b]); },
                stop());
  return true;
}

void AxisSweep::CollectMoved(std::span<const Aabb> boxes) {
  moved_ids_.EnsureDiscarding(count_);
  moved_.Clear(count_);
  const size_t moved_count = FindMoved(boxes, records_.data(), moved_ids_.data());
  for (size_t k = 0; k < moved_count; ++k) moved_.Add(moved_ids_[k] & ~kBecameInvalid);
}

bool AxisSweep::RepairAxis(std::span<const Aabb> boxes, size_t axis, SwapAllowance& allowance) {
  for (size_t k = 0; k < moved_.count(); ++k) {
    const uint32_t id = moved_ids_[k] & ~kBecameInvalid;
    const bool is_invalid = (moved_ids_[k] & kBecameInvalid) != 0;
    records_[id].min[axis] = is_invalid ? kInfinity : boxes[id].min[axis];
    records_[id].max[axis] = is_invalid ? -kInfinity : boxes[id].max[axis];
  }
  if (!pairs_known_)
    return axes_[axis].Repair(records(), moved_, rooms_[0], allowance, [](uint32_t, uint32_t) {});
  const size_t second = (axis + 1) % 3;
  const size_t third = (axis + 2) % 3;
  return axes_[axis].Repair(records(), moved_, rooms_[0], allowance, [&](uint32_t a, uint32_t b) {
    ++checks_;
    if (OverlapOn(records_[a], records_[b], second) && OverlapOn(records_[a], records_[b], third))
      pairs_.Touch(a, b);
  });
}

// Returns steps that hold four faces each on average. Finer steps would cost more to count than
// they save.
SweepAxis AxisSweep::StepsOn(size_t axis) const {
  const auto steps = static_cast<float>(std::clamp<size_t>(count_ / 2, 64, 65536));
  return {false, range_.low[axis], steps / range_.width(static_cast<int>(axis)), steps - 1};
}

void AxisSweep::SortAxis(size_t axis, size_t room) {
  axes_[axis].Sort(records(), StepsOn(axis), rooms_[room], stop());
}

// Sorts all three axes and fills the sweep's lanes. With threads, it sorts two axes in parallel,
// and then the third while it fills the lanes.
void AxisSweep::SortAll() {
  pairs_known_ = false;
  if (IsStopped(stop())) return;
  const auto first = static_cast<size_t>(range_.sweep_axis);
  const bool threads = BoxParts() > 1;
  swept_.ResizeFor(records_.data(), count_);
  RunParts(threads ? executor_ : nullptr, 2, [&](size_t part) {
    SortAxis((first + part) % 3, threads ? part : 0);
    if (part == 0 && !IsStopped(stop())) SetSweepOrder();
  });
  if (IsStopped(stop())) return;
  const size_t fill_parts = BoxParts();
  RunParts(executor_, 1 + fill_parts, [&](size_t part) {
    part == 0 ? SortAxis((first + 2) % 3, 0) : FillLanes(part - 1, fill_parts);
  });
}

// Writes the boxes' ids to the slots of the sweep, in the order of their lower faces.
void AxisSweep::SetSweepOrder() {
  uint32_t* const ids = swept_.ids();
  size_t slot = 0;
  for (const Endpoint endpoint : axes_[static_cast<size_t>(range_.sweep_axis)].endpoints()) {
    ids[slot] = EndpointOwner(endpoint);
    slot += IsUpperFace(endpoint) ? 0 : 1;
  }
  // Restores the padding, which the last upper face overwrote.
  ids[count_] = static_cast<uint32_t>(count_);
}

void AxisSweep::FillLanes(size_t part, size_t part_count) {
  const PartRange slots = RangeOfPart(count_, part, part_count, ByteBoxes::kGranule);
  const auto axis = static_cast<size_t>(range_.sweep_axis);
  const SweepAxis sweep = axes_[axis].is_exact() ? SweepAxis{} : StepsOn(axis);
  ForEachBlock(stop(), slots.begin, slots.end,
               [&](size_t from, size_t to) { swept_.Fill(range_, sweep, from, to); });
}

void AxisSweep::PrepareSweep() {
  swept_.ResizeFor(records_.data(), count_);
  SetSweepOrder();
  const size_t part_count = BoxParts();
  RunParts(executor_, part_count, [&](size_t part) { FillLanes(part, part_count); });
}

void AxisSweep::CopyPairs(PairBuffer& out) const {
  const std::span<const OverlapPair> pairs = pairs_.pairs();
  std::copy(pairs.begin(), pairs.end(), out.EnsureRoom(pairs.size()));
  out.Advance(pairs.size());
}

}  // namespace

std::unique_ptr<BroadPhase> MakeAxisSweep(const BroadPhaseOptions& options) {
  return std::make_unique<AxisSweep>(options);
}

}  // namespace sweepstake
