#include "engine_client/broad_phase/grid/grid_sort.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/common/parallel.h"
#include "hwy/cache_control.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid/grid_sort.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Writes the cell of each box to `keys`, a register at a time, and counts the boxes of each cell.
void CountKeys(std::span<const Aabb> boxes, std::span<const GroupGrid> grids,
               const GroupChoice& choice, uint32_t* keys, uint32_t* counts) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto absent = hn::Set(di, static_cast<int32_t>(grids.back().last_cell()));
  const auto* const group_of_class = reinterpret_cast<const int32_t*>(choice.group_of_class);
  const auto count_keys = [&](size_t at, auto valid, auto x, auto y, auto z, auto max_x, auto max_y,
                              auto max_z) HWY_ATTR {
    auto cells = hn::Zero(di);
    if (grids.size() == 1) {
      cells = CellOfCorner(d, grids[0], x, y, z);
    } else {
      const auto classes = ClassesOfSides(d, choice.classes, hn::Sub(max_x, x), hn::Sub(max_y, y),
                                          hn::Sub(max_z, z));
      cells = CellInGroup(d, grids, hn::GatherIndex(di, group_of_class, classes), x, y, z);
    }
    cells = hn::IfThenElse(hn::RebindMask(di, valid), cells, absent);
    hn::StoreU(hn::BitCast(du, cells), du, keys + at);
    const size_t end = std::min(at + hn::Lanes(d), boxes.size());
    for (size_t k = at; k < end; ++k) ++counts[keys[k]];
  };
  ForEachHalved(d, boxes, count_keys);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(CountKeys);

namespace {

// The prefetch distance in boxes. It is large enough to hide the latency of main memory.
constexpr size_t kAhead = 24;

// Returns `count` rounded up, with padding for kernels that read a register behind the last slot.
constexpr size_t Padded(size_t count) {
  return (count + 2 * SoaBoxes::kPadding - 1) / SoaBoxes::kPadding * SoaBoxes::kPadding;
}

constexpr size_t kMinSortedPerPart = 2048;

}  // namespace

void GridColumns::Resize(size_t count, bool is_stretched) {
  count_ = count;
  stride_ = Padded(count);
  is_stretched_ = is_stretched;
  floats_.EnsureDiscarding(6 * stride_);
  if (is_stretched) stretched_.EnsureDiscarding(6 * stride_);
  ids_.EnsureDiscarding(stride_);
  for (size_t slot = count; slot < stride_; ++slot) Invalidate(slot);
  std::fill(ids_.data() + count, ids_.data() + stride_, 0U);
}

void GridColumns::Gather(const GridBoxes& boxes, size_t begin, size_t end) {
  GatherInto(floats_, boxes.boxes, begin, end);
  if (is_stretched_) GatherInto(stretched_, boxes.in_grids, begin, end);
}

void GridColumns::GatherInto(AlignedBuffer<float>& floats, std::span<const Aabb> boxes,
                             size_t begin, size_t end) {
  float* const columns[6] = {floats.data(),
                             floats.data() + stride_,
                             floats.data() + 2 * stride_,
                             floats.data() + 3 * stride_,
                             floats.data() + 4 * stride_,
                             floats.data() + 5 * stride_};
  const uint32_t* const ids = ids_.data();
  for (size_t k = begin; k < end; ++k) {
    hwy::Prefetch(&boxes[ids[std::min(k + kAhead, end - 1)]]);
    const Aabb& box = boxes[ids[k]];
    for (size_t axis = 0; axis < 3; ++axis) {
      columns[axis][k] = box.min[axis];
      columns[axis + 3][k] = box.max[axis];
    }
  }
}

void GridColumns::Invalidate(size_t slot) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (size_t column = 0; column < 6; ++column) {
    floats_[column * stride_ + slot] = kNan;
    if (is_stretched_) stretched_[column * stride_ + slot] = kNan;
  }
}

BoxLanes GridColumns::LanesOf(const AlignedBuffer<float>& floats) const {
  BoxLanes lanes{};
  for (size_t axis = 0; axis < 3; ++axis) {
    lanes.min[axis] = floats.data() + axis * stride_;
    lanes.max[axis] = floats.data() + (axis + 3) * stride_;
  }
  lanes.id = ids_.data();
  lanes.count = count_;
  return lanes;
}

void GridSort::Sort(Executor* executor, const GridBoxes& boxes, std::span<const GroupGrid> grids,
                    const GroupChoice& choice, StopRequest* stop) {
  count_ = boxes.size();
  cells_ = size_t{grids.back().last_cell()} + 1;
  const size_t parts = TablePartCount(executor, count_, kMinSortedPerPart);
  MakeRoom(parts, boxes.is_stretched());
  CountInParts(executor, parts, boxes.in_grids, grids, choice, stop);
  if (IsStopped(stop)) return;
  SumCounts(parts);
  // Parts are ranges of cells, not of boxes, so that threads do not write to the same cache lines.
  RunParts(executor, parts, [&](size_t part) {
    const size_t begin = FirstCellOfPart(part, parts);
    const size_t end = FirstCellOfPart(part + 1, parts);
    if (!Place(begin, end, stop)) return;
    ForEachBlock(stop, starts_[begin], starts_[end],
                 [&](size_t from, size_t to) { columns_.Gather(boxes, from, to); });
  });
}

void GridSort::MakeRoom(size_t parts, bool is_stretched) {
  keys_.EnsureDiscarding(count_ + SoaBoxes::kPadding);
  columns_.Resize(count_, is_stretched);
  // Reserves spare room, since the number of cells fluctuates with the bounds of the boxes.
  starts_.EnsureWithSpare(cells_ + 1);
  part_counts_.EnsureWithSpare(parts * cells_);
}

void GridSort::CountInParts(Executor* executor, size_t parts, std::span<const Aabb> boxes,
                            std::span<const GroupGrid> grids, const GroupChoice& choice,
                            StopRequest* stop) {
  RunParts(executor, parts, [&](size_t part) {
    uint32_t* const counts = part_counts_.data() + part * cells_;
    std::fill_n(counts, cells_, 0U);
    const PartRange range = RangeOfPart(count_, part, parts, SoaBoxes::kPadding);
    ForEachBlock(stop, range.begin, range.end, [&](size_t from, size_t to) {
      HWY_DYNAMIC_DISPATCH(CountKeys)
      (boxes.subspan(from, to - from), grids, choice, keys_.data() + from, counts);
    });
  });
}

// Computes the first slot of each cell from the counts of all parts. The first part's counts are
// replaced by the next free slot of each cell.
void GridSort::SumCounts(size_t parts) {
  uint32_t slot = 0;
  for (size_t cell = 0; cell < cells_; ++cell) {
    starts_[cell] = slot;
    for (size_t part = 0; part < parts; ++part) slot += part_counts_[part * cells_ + cell];
    part_counts_[cell] = starts_[cell];
  }
  starts_[cells_] = slot;
}

// Returns the first cell of a part. Parts hold about the same number of boxes.
size_t GridSort::FirstCellOfPart(size_t part, size_t parts) const {
  if (part == 0) return 0;
  if (part == parts) return cells_;
  const uint32_t* const starts = starts_.data();
  const auto slot = static_cast<uint32_t>(count_ * part / parts);
  return static_cast<size_t>(std::lower_bound(starts, starts + cells_, slot) - starts);
}

// Writes the boxes of the cells [begin, end) to their slots. Returns false if `stop` ended it.
bool GridSort::Place(size_t begin, size_t end, StopRequest* stop) {
  uint32_t* const next = part_counts_.data();
  uint32_t* const order = columns_.ids();
  const uint32_t* const keys = keys_.data();
  if (begin == 0 && end == cells_) {
    return ForEachBlock(stop, 0, count_, [&](size_t from, size_t to) {
      for (size_t i = from; i < to; ++i) order[next[keys[i]]++] = static_cast<uint32_t>(i);
    });
  }
  // First lists the boxes of these cells without a branch, then places them. A branch on the cell
  // of each box would often be mispredicted.
  constexpr size_t kListRoom = 256;
  uint32_t listed[kListRoom];
  for (size_t from = 0; from < count_; from += kListRoom) {
    const size_t to = std::min(from + kListRoom, count_);
    size_t count = 0;
    for (size_t i = from; i < to; ++i) {
      listed[count] = static_cast<uint32_t>(i);
      count += keys[i] - begin < end - begin ? 1 : 0;
    }
    for (size_t k = 0; k < count; ++k) order[next[keys[listed[k]]]++] = listed[k];
  }
  return !IsStopped(stop);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
