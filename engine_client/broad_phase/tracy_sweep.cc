#include "engine_client/broad_phase/tracy_sweep.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/tracy_ranges.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/tracy_sweep.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/grid_cells-inl.h"
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Marks of an entry: bit k, the box begins in this cell on the k-th axis from the sweep axis on. A
// pair is reported where, on each axis, one of the two begins.
constexpr uint32_t kBeginsOnAllAxes = 7;
constexpr uint32_t kNotInCell = 8;

// Shifts per entry after which a list counts as unsorted.
constexpr size_t kShiftsPerEntry = 8;

// Insertion, since the list was in order a frame ago; it gives up where that is no longer so.
HWY_INLINE void SortEntries(SweepRoom::Entry* entries, size_t count) {
  size_t shifts = 0;
  for (size_t i = 1; i < count; ++i) {
    const SweepRoom::Entry entry = entries[i];
    size_t at = i;
    for (; at > 0 && entries[at - 1].key > entry.key; --at) entries[at] = entries[at - 1];
    entries[at] = entry;
    shifts += i - at;
    if (shifts > kShiftsPerEntry * count) break;
  }
  if (shifts <= kShiftsPerEntry * count) return;
  std::sort(entries, entries + count, [](const SweepRoom::Entry& a, const SweepRoom::Entry& b) {
    return a.key < b.key || (a.key == b.key && a.id < b.id);
  });
}

HWY_INLINE BoxLanes LanesOf(SweepRoom& room, size_t count) {
  return {{room.column(0), room.column(1), room.column(2)},
          {room.column(3), room.column(4), room.column(5)},
          room.ids(),
          count};
}

// The boxes of the list into the columns, in order, and sentinels behind them.
HWY_INLINE void LoadSorted(const SweepInput& input, std::span<const uint32_t> list,
                           SweepRoom& room) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  SweepRoom::Entry* const entries = room.entries();
  const size_t count = list.size();
  for (size_t k = 0; k < count; ++k) {
    entries[k] = {input.boxes[list[k]].min[input.axis], list[k]};
  }
  SortEntries(entries, count);
  for (size_t k = 0; k < count; ++k) room.ids()[k] = entries[k].id;
  std::fill_n(room.ids() + count, SoaBoxes::kPadding, 0U);
  for (size_t k = 0; k < 3; ++k) {
    const size_t axis = (input.axis + k) % 3;
    float* const min = room.column(k);
    float* const max = room.column(3 + k);
    for (size_t i = 0; i < count; ++i) {
      const Aabb& box = input.boxes[entries[i].id];
      min[i] = box.min[axis];
      max[i] = box.max[axis];
    }
    std::fill_n(min + count, SoaBoxes::kPadding, kInfinity);
    std::fill_n(max + count, SoaBoxes::kPadding, -kInfinity);
  }
}

HWY_INLINE void MarkEntries(const SweepInput& input, const CellPosition& position,
                            const BoxLanes& lanes, uint32_t* marks) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto one = hn::Set(di, 1);
  const auto most = hn::Set(di, CellRange::kMostCells);
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  for (size_t at = 0; at < lanes.count; at += hn::Lanes(d)) {
    auto mark = hn::Zero(di);
    auto cells = one;
    auto outside = hn::RebindMask(di, hn::Eq(hn::LoadU(d, lanes.min[0] + at), infinity));
    for (size_t k = 0; k < 3; ++k) {
      const size_t axis = (input.axis + k) % 3;
      const auto here = hn::Set(di, static_cast<int32_t>(position.at[axis]));
      const auto from = CellsOf(d, input.layout, axis, lanes.min[k] + at);
      const auto to = CellsOf(d, input.layout, axis, lanes.max[k] + at);
      cells = hn::Mul(cells, hn::Min(hn::Add(hn::Sub(to, from), one), hn::Add(most, one)));
      outside = hn::Or(outside, hn::Or(hn::Gt(from, here), hn::Lt(to, here)));
      mark = hn::Or(mark, hn::IfThenElseZero(hn::Eq(from, here), hn::Set(di, 1 << k)));
    }
    outside = hn::Or(outside, hn::Gt(cells, most));
    mark = hn::Or(mark, hn::IfThenElseZero(outside, hn::Set(di, kNotInCell)));
    hn::StoreU(hn::BitCast(du, mark), du, marks + at);
  }
}

// Writes the sorted list back without the boxes that are not in the cell. Returns how many are.
HWY_INLINE size_t KeepInside(const BoxLanes& lanes, const uint32_t* marks,
                             std::span<uint32_t> list) {
  size_t kept = 0;
  for (size_t k = 0; k < list.size(); ++k) {
    list[kept] = lanes.id[k];
    kept += marks[k] < kNotInCell ? 1 : 0;
  }
  return kept;
}

HWY_INLINE uint64_t SweepEntries(const BoxLanes& lanes, const uint32_t* marks, PairCursor& cursor) {
  const HWY_FULL(float) d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const size_t step = hn::Lanes(d);
  const auto wanted = hn::Set(du, kBeginsOnAllAxes);
  uint64_t checks = 0;
  for (size_t i = 0; i < lanes.count; ++i) {
    if (marks[i] >= kNotInCell) continue;
    const Aabb box = BoxAt(lanes, i);
    const auto mark = hn::Set(du, marks[i]);
    for (size_t at = i + 1; lanes.min[0][at] <= box.max[0]; at += step) {
      const auto here = hn::Eq(hn::Or(mark, hn::LoadU(du, marks + at)), wanted);
      const auto hits =
          hn::And(Hits<FirstAxis::kSorted>(d, box, lanes, at), hn::RebindMask(d, here));
      cursor.Advance(StoreHits(d, hits, lanes.id[i], lanes.id + at, cursor.Room(step)));
      checks += step;
    }
  }
  return checks;
}

HWY_INLINE void TidyCell(const SweepInput& input, size_t cell, CellLists& lists, SweepRoom& room) {
  const std::span<uint32_t> list = lists.ids(cell);
  room.Ensure(list.size());
  LoadSorted(input, list, room);
  const BoxLanes lanes = LanesOf(room, list.size());
  const CellPosition position = PositionOf(input.layout, static_cast<uint32_t>(cell));
  MarkEntries(input, position, lanes, room.marks());
  lists.Truncate(cell, KeepInside(lanes, room.marks(), list));
}

void TidyAll(const SweepInput& input, CellLists& lists, SweepRoom& room) {
  for (size_t cell = 0; cell < lists.size(); ++cell) {
    if (!lists.ids(cell).empty()) TidyCell(input, cell, lists, room);
  }
}

uint64_t SweepAll(const SweepInput& input, CellLists& lists, SweepRoom& room, PairBuffer& out) {
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (size_t cell = 0; cell < lists.size(); ++cell) {
    const size_t count = lists.ids(cell).size();
    if (count == 0) continue;
    TidyCell(input, cell, lists, room);
    checks += SweepEntries(LanesOf(room, count), room.marks(), cursor);
  }
  cursor.Flush();
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(SweepAll);
HWY_EXPORT(TidyAll);

void SweepRoom::Ensure(size_t entry_count) {
  if (entry_count + 2 * SoaBoxes::kPadding <= stride_) return;
  stride_ = (entry_count + entry_count / 2 + 8 * SoaBoxes::kPadding) / SoaBoxes::kPadding *
            SoaBoxes::kPadding;
  entries_.EnsureDiscarding(stride_);
  floats_.EnsureDiscarding(6 * stride_);
  words_.EnsureDiscarding(2 * stride_);
}

uint64_t SweepCells(const SweepInput& input, CellLists& lists, SweepRoom& room, PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(SweepAll)(input, lists, room, out);
}

void TidyCells(const SweepInput& input, CellLists& lists, SweepRoom& room) {
  HWY_DYNAMIC_DISPATCH(TidyAll)(input, lists, room);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
