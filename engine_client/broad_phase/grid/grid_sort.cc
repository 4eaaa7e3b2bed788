#include "engine_client/broad_phase/grid/grid_sort.h"

#include <algorithm>

#include "engine_client/broad_phase/common/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid/grid_sort.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"
#include "engine_client/broad_phase/grid/grid_classes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Keys of the boxes, and how many boxes have each. Writes a register of keys at a time.
void CountKeys(std::span<const Aabb> boxes, std::span<const GroupGrid> grids,
               const GroupChoice& choice, uint32_t* keys, uint32_t* counts) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto absent = hn::Set(di, static_cast<int32_t>(grids.back().last_cell()));
  const auto* const group_of_class = reinterpret_cast<const int32_t*>(choice.group_of_class);
  ForEachRegister(d, boxes, [&](const Aabb* from, size_t at) HWY_ATTR {
    auto x = hn::Zero(d);
    auto y = x;
    auto z = x;
    auto max_x = x;
    auto max_y = x;
    auto max_z = x;
    const auto present = LoadHalved(d, from, x, y, z, max_x, max_y, max_z);
    auto cells = hn::Zero(di);
    if (grids.size() == 1) {
      cells = CellOfCorner(d, grids[0], x, y, z);
    } else {
      const auto classes = ClassesOfSides(d, choice.classes, hn::Sub(max_x, x), hn::Sub(max_y, y),
                                          hn::Sub(max_z, z));
      cells = CellInGroup(d, grids, hn::GatherIndex(di, group_of_class, classes), x, y, z);
    }
    cells = hn::IfThenElse(hn::RebindMask(di, present), cells, absent);
    hn::StoreU(hn::BitCast(du, cells), du, keys + at);
    const size_t end = std::min(at + hn::Lanes(d), boxes.size());
    for (size_t k = at; k < end; ++k) ++counts[keys[k]];
  });
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(CountKeys);

namespace {

// Each part has counts of its own, which cost as much as the boxes of a cell.
constexpr size_t kMostParts = 8;
constexpr size_t kLeastBoxesPerPart = 2048;

size_t PartsFor(const Executor* executor, size_t count) {
  if (executor == nullptr) return 1;
  const size_t most = std::min(executor->thread_count(), kMostParts);
  return std::clamp<size_t>(count / kLeastBoxesPerPart, 1, most);
}

}  // namespace

void GridSort::Sort(Executor* executor, std::span<const Aabb> boxes,
                    std::span<const GroupGrid> grids, const GroupChoice& choice) {
  count_ = boxes.size();
  cells_ = size_t{grids.back().last_cell()} + 1;
  const size_t parts = PartsFor(executor, count_);
  MakeRoom(parts);
  CountInParts(executor, parts, boxes, grids, choice);
  SumCounts(parts);
  // By cells, not by boxes: threads that write into one another's cache lines wait for one another.
  RunParts(executor, parts, [&](size_t part) {
    const size_t begin = FirstCellOfPart(part, parts);
    const size_t end = FirstCellOfPart(part + 1, parts);
    Place(begin, end);
    columns_.Gather(boxes, starts_[begin], starts_[end]);
  });
}

void GridSort::MakeRoom(size_t parts) {
  keys_.EnsureDiscarding(count_ + SoaBoxes::kPadding);
  columns_.Resize(count_);
  // The number of cells follows the bounds.
  starts_.EnsureWithSpare(cells_ + 1);
  part_counts_.EnsureWithSpare(parts * cells_);
}

void GridSort::CountInParts(Executor* executor, size_t parts, std::span<const Aabb> boxes,
                            std::span<const GroupGrid> grids, const GroupChoice& choice) {
  RunParts(executor, parts, [&](size_t part) {
    uint32_t* const counts = part_counts_.data() + part * cells_;
    std::fill_n(counts, cells_, 0U);
    const PartRange range = RangeOfPart(count_, part, parts, SoaBoxes::kPadding);
    HWY_DYNAMIC_DISPATCH(CountKeys)
    (boxes.subspan(range.begin, range.end - range.begin), grids, choice, keys_.data() + range.begin,
     counts);
  });
}

// From the counts of the parts to the slots where cells begin. The counts of the first part become
// the slots that are free next.
void GridSort::SumCounts(size_t parts) {
  uint32_t slot = 0;
  for (size_t cell = 0; cell < cells_; ++cell) {
    starts_[cell] = slot;
    for (size_t part = 0; part < parts; ++part) slot += part_counts_[part * cells_ + cell];
    part_counts_[cell] = starts_[cell];
  }
  starts_[cells_] = slot;
}

// Such that parts hold about as many boxes each.
size_t GridSort::FirstCellOfPart(size_t part, size_t parts) const {
  if (part == 0) return 0;
  if (part == parts) return cells_;
  const uint32_t* const starts = starts_.data();
  const auto slot = static_cast<uint32_t>(count_ * part / parts);
  return static_cast<size_t>(std::lower_bound(starts, starts + cells_, slot) - starts);
}

// The boxes of the cells [begin, end) into their slots.
void GridSort::Place(size_t begin, size_t end) {
  uint32_t* const next = part_counts_.data();
  uint32_t* const order = columns_.ids();
  const uint32_t* const keys = keys_.data();
  if (begin == 0 && end == cells_) {
    for (size_t i = 0; i < count_; ++i) order[next[keys[i]]++] = static_cast<uint32_t>(i);
    return;
  }
  // Listed before they are placed, since a branch on cells in no order is mispredicted.
  constexpr size_t kListed = 256;
  uint32_t listed[kListed];
  for (size_t from = 0; from < count_; from += kListed) {
    const size_t to = std::min(from + kListed, count_);
    size_t count = 0;
    for (size_t i = from; i < to; ++i) {
      listed[count] = static_cast<uint32_t>(i);
      count += keys[i] - begin < end - begin ? 1 : 0;
    }
    for (size_t k = 0; k < count; ++k) order[next[keys[listed[k]]]++] = listed[k];
  }
}

}  // namespace sweepstake

#endif  // HWY_ONCE
