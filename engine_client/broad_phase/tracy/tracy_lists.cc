#include "engine_client/broad_phase/tracy/tracy_lists.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/radix_sort.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "hwy/cache_control.h"

namespace sweepstake {
namespace {

constexpr size_t kMinListedPerPart = 2048;
// The number of boxes whose rows are found at a time, so that they stay in the L1 cache.
constexpr size_t kBatch = 512;
// If an insertion sort takes more than this number of shifts per item, std::sort replaces it.
constexpr size_t kShiftsPerItem = 8;
// A cell counts as at most this many times as long as the longest box, because margins that are
// wide compared with the boxes add many pairs. Boxes shorter than kMinSide count as points.
constexpr float kMaxSidesPerCell = 8;
constexpr float kMinSide = 1e-30F;
// The prefetch distance in items. It is large enough to hide the latency of main memory.
constexpr size_t kPrefetchDistance = 16;

// Sorts by insertion, which is fast for a list that was sorted in the last frame. Uses std::sort
// instead if the insertions take too many shifts.
void SortItems(uint64_t* items, size_t count) {
  size_t shifts = 0;
  for (size_t i = 1; i < count; ++i) {
    const uint64_t item = items[i];
    size_t at = i;
    for (; at > 0 && item < items[at - 1]; --at) items[at] = items[at - 1];
    items[at] = item;
    shifts += i - at;
    if (shifts > kShiftsPerItem * count) {
      std::sort(items, items + count);
      return;
    }
  }
}

// Merges two consecutive sorted runs in `items`. The second run is short, and `from` is a copy of
// it.
void MergeItems(uint64_t* items, size_t first, const uint64_t* from, size_t second) {
  size_t to = first + second;
  while (second > 0) {
    const bool later = first > 0 && from[second - 1] < items[first - 1];
    items[--to] = later ? items[--first] : from[--second];
  }
}

}  // namespace

void TracyLists::Reset(const RowGrids& grids) {
  grids_ = grids;
  grids_without_margin_ = grids;
  count_ = 0;
  size_ = 0;
  first_slots_.EnsureWithSpare(grids_.row_count() + 1);
  std::fill_n(first_slots_.data(), grids_.row_count() + 1, 0U);
}

void TracyLists::MakeRoom(size_t count, size_t parts) {
  const size_t rows = grids_.row_count();
  const size_t cells = grids_.grids[grids_.group_count - 1].last_cell() + 1;
  rows_.EnsureKeeping(count + SoaBoxes::kPadding, count_);
  arrived_.EnsureDiscarding(count + SoaBoxes::kPadding);
  old_slots_.EnsureWithSpare(rows + 1);
  arrivals_.EnsureWithSpare(rows);
  starts_.EnsureWithSpare(cells + 2);  // one more cell holds the query boxes
  if (parts_.size() < parts) parts_.resize(parts);
  for (size_t part = 0; part < parts; ++part) {
    parts_[part].change.EnsureWithSpare(rows);
    std::fill_n(parts_[part].change.data(), rows, 0);
  }
}

// Removes the objects from index `count` on. Added objects get a row only in Update.
void TracyLists::SetCount(size_t count) {
  for (size_t i = count; i < count_; ++i) {
    if (rows_[i] != kNoRow) --parts_[0].change[rows_[i]];
  }
  if (count > count_) std::fill(rows_.data() + count_, rows_.data() + count, kNoRow);
  count_ = count;
}

void TracyLists::Update(Executor* executor, const GridBoxes& boxes, size_t query_count,
                        StopRequest* stop) {
  const size_t parts = TablePartCount(executor, boxes.size(), kMinListedPerPart);
  // Copies the lists, which are overwritten below.
  order_.EnsureDiscarding(std::max(boxes.size(), size_) + SoaBoxes::kPadding);
  std::copy_n(columns_.ids(), size_, order_.data());
  MakeRoom(boxes.size(), parts);
  SetCount(boxes.size());
  // Finds the boxes whose row has changed, and the new positions of the lists.
  RunParts(executor, parts, [&](size_t index) {
    const PartRange range = RangeOfPart(boxes.size(), index, parts, SoaBoxes::kPadding);
    parts_[index].begin = range.begin;
    MoveBoxes(boxes.in_grids, parts_[index], range.end, stop);
  });
  if (IsStopped(stop)) return;
  PlaceLists(parts);
  // Appends the boxes that have arrived to their lists.
  columns_.Resize(size_ + query_count, boxes.is_stretched());
  for (size_t index = 0; index < parts; ++index) PlaceArrivals(parts_[index], stop);
  if (IsStopped(stop)) return;
  // Sorts the lists. They are divided into parts with about the same number of boxes.
  RunParts(executor, parts, [&](size_t index) {
    const uint32_t* const slots = first_slots_.data();
    const uint32_t* const end = slots + grids_.row_count();
    const auto border = [&](size_t k) {
      if (k == parts) return grids_.row_count();
      const auto slot = static_cast<uint32_t>(size_ * k / parts);
      return static_cast<uint32_t>(k == 0 ? 0 : std::lower_bound(slots, end, slot) - slots);
    };
    SweepRows(boxes, border(index), border(index + 1), parts_[index], stop);
  });
  starts_[grids_.grids[grids_.group_count - 1].last_cell()] = static_cast<uint32_t>(size_);
}

void TracyLists::SetMargin(float margin) {
  constexpr float kRounding = 1.001F;
  grids_ = grids_without_margin_;
  if (margin == 0) return;
  for (size_t group = 0; group + 1 < grids_.group_count; ++group) {
    for (int axis = 0; axis < 3; ++axis) {
      float& reach = grids_.grids[group].reach[axis];
      reach = (reach + margin) * kRounding;  // the reach is half a side, which grows by 2 margins
      grids_.row_grids[group].reach[axis] = reach;
    }
  }
}

float TracyLists::narrowest_cell() const {
  float narrowest = std::numeric_limits<float>::max();
  for (size_t group = 0; group + 1 < grids_.group_count; ++group) {
    const GroupGrid& grid = grids_.grids[group];
    const float along = GroupGrid::kRowCells * 2 / grid.scale[grid.AxisOf(0)];
    const float across = 2 / std::max(grid.scale[grid.AxisOf(1)], grid.scale[grid.AxisOf(2)]);
    narrowest = std::min({narrowest, along, across});
    const float longest = 2 * *std::max_element(grid.reach, grid.reach + 3);
    if (longest > kMinSide) narrowest = std::min(narrowest, kMaxSidesPerCell * longest);
  }
  return narrowest;
}

void TracyLists::Invalidate(uint32_t object) {
  const uint32_t row = rows_[object];
  if (row == kNoRow) return;
  const uint32_t* const ids = columns_.ids();
  const uint32_t* const slot =
      std::find(ids + first_slots_[row], ids + first_slots_[row + 1], object);
  columns_.Invalidate(static_cast<size_t>(slot - ids));
}

uint64_t TracyLists::SearchFor(const GridBoxes& boxes, std::span<const uint32_t> ids,
                               PairBuffer& out, StopRequest* stop) {
  // The query boxes (SearchFor) form one more group, whose grid has one cell. It searches all other
  // groups.
  std::array<GroupGrid, RowGrids::kMaxGroups + 1> grids;
  std::array<uint32_t, RowGrids::kMaxGroups + 1> searches;
  std::copy_n(grids_.grids.begin(), grids_.group_count, grids.begin());
  std::copy_n(grids_.searches.begin(), grids_.group_count, searches.begin());
  grids[grids_.group_count] = grids[grids_.group_count - 1];
  GroupGrid& query = grids[grids_.group_count];
  query.first_cell = grids[grids_.group_count - 1].last_cell();
  searches[grids_.group_count] = (1U << grids_.group_count) - 1;
  const size_t end = size_ + ids.size();
  std::copy(ids.begin(), ids.end(), columns_.ids() + size_);
  columns_.Gather(boxes, size_, end);
  starts_[query.last_cell()] = static_cast<uint32_t>(end);
  const GridView view{columns_.lanes(),
                      columns_.in_grids(),
                      starts_.data(),
                      {grids.data(), grids_.group_count + 1},
                      searches.data()};
  return SearchGrids(view, size_, end, out, stop);
}

// Finds the boxes of [part.begin, end) that have moved to another list.
void TracyLists::MoveBoxes(std::span<const Aabb> boxes, Part& part, size_t end, StopRequest* stop) {
  uint32_t moved[kBatch + SoaBoxes::kPadding];
  uint32_t new_rows[kBatch + SoaBoxes::kPadding];
  int32_t* const change = part.change.data();
  size_t arrived = part.begin;
  size_t next_question = part.begin;
  for (size_t begin = part.begin; begin < end; begin += kBatch) {
    if (begin >= next_question) {
      if (IsStopped(stop)) return;
      next_question = begin + kBoxesPerQuestion;
    }
    const size_t count = FindMovedRows(boxes.subspan(begin, std::min(kBatch, end - begin)), grids_,
                                       rows_.data() + begin, moved, new_rows);
    for (size_t k = 0; k < count; ++k) {
      const size_t object = begin + moved[k];
      if (rows_[object] != kNoRow) --change[rows_[object]];
      rows_[object] = new_rows[k];
      if (new_rows[k] == kNoRow) continue;
      ++change[new_rows[k]];
      arrived_[arrived++] = static_cast<uint32_t>(object);
    }
  }
  part.arrived = arrived - part.begin;
}

// Computes the new first slots of the lists and, in each list, the first slot for arrived boxes,
// behind the boxes that have stayed.
void TracyLists::PlaceLists(size_t parts) {
  std::swap(first_slots_, old_slots_);
  const uint32_t rows = grids_.row_count();
  first_slots_.EnsureWithSpare(rows + 1);
  std::fill_n(arrivals_.data(), rows, 0U);
  moved_count_ = 0;
  for (size_t index = 0; index < parts; ++index) {
    const Part& part = parts_[index];
    moved_count_ += part.arrived;
    for (size_t k = part.begin; k < part.begin + part.arrived; ++k) {
      ++arrivals_[rows_[arrived_[k]]];
    }
  }
  uint32_t slot = 0;
  for (uint32_t row = 0; row < rows; ++row) {
    int32_t length = static_cast<int32_t>(old_slots_[row + 1] - old_slots_[row]);
    for (size_t index = 0; index < parts; ++index) length += parts_[index].change[row];
    first_slots_[row] = slot;
    slot += static_cast<uint32_t>(length);
    arrivals_[row] = slot - arrivals_[row];
  }
  first_slots_[rows] = slot;
  size_ = slot;
}

void TracyLists::PlaceArrivals(const Part& part, StopRequest* stop) {
  ForEachBlock(stop, part.begin, part.begin + part.arrived, [&](size_t from, size_t to) {
    for (size_t k = from; k < to; ++k) {
      columns_.ids()[arrivals_[rows_[arrived_[k]]]++] = arrived_[k];
    }
  });
}

void TracyLists::SweepRows(const GridBoxes& boxes, uint32_t begin, uint32_t end, Part& part,
                           StopRequest* stop) {
  size_t next_question = first_slots_[begin];
  for (size_t group = 0; group < grids_.group_count; ++group) {
    const GroupGrid& grid = grids_.grids[group];
    const uint32_t first_row = grids_.row_grids[group].first_cell;
    const uint32_t last_row = first_row + grid.cells[grid.AxisOf(1)] * grid.cells[grid.AxisOf(2)];
    for (uint32_t row = std::max(begin, first_row); row < std::min(end, last_row); ++row) {
      if (first_slots_[row] >= next_question) {
        if (IsStopped(stop)) return;
        next_question = first_slots_[row] + kBoxesPerQuestion;
      }
      SweepRow(boxes, row, grid, row - first_row, part);
    }
  }
}

void TracyLists::SweepRow(const GridBoxes& boxes, uint32_t row, const GroupGrid& grid,
                          uint32_t grid_row, Part& part) {
  const uint32_t begin = first_slots_[row];
  const uint32_t end = first_slots_[row + 1];
  const size_t count = end - begin;
  if (count > 0) {
    const size_t stayed = CollectItems(boxes.in_grids, row, grid.AxisOf(0), part);
    uint64_t* const items = part.items.data();
    SortItems(items, stayed);
    if (stayed < count) {
      SortItems(items + stayed, count - stayed);
      std::copy(items + stayed, items + count, items + count);
      MergeItems(items, stayed, items + count, count - stayed);
    }
    for (size_t k = 0; k < count; ++k) columns_.ids()[begin + k] = SortItemPayload(items[k]);
    columns_.Gather(boxes, begin, end);
  }
  const uint32_t row_cells = grid.cells[grid.AxisOf(0)];
  MarkCells(grid, grid.first_cell + grid_row * row_cells, begin, end, part);
}

// Collects the boxes of a row as sort items: first the boxes that have stayed, in the order of the
// old list, then the arrived boxes. Returns the number of boxes that have stayed.
size_t TracyLists::CollectItems(std::span<const Aabb> boxes, uint32_t row, size_t axis,
                                Part& part) {
  const size_t begin = first_slots_[row];
  const size_t count = first_slots_[row + 1] - begin;
  const size_t old_begin = old_slots_[row];
  const size_t old_end = old_slots_[row + 1];
  part.items.EnsureDiscarding(std::max(2 * count, old_end - old_begin) + 1);
  uint64_t* const items = part.items.data();
  const uint32_t* const order = order_.data();
  size_t stayed = 0;
  for (size_t k = old_begin; k < old_end; ++k) {
    hwy::Prefetch(&boxes[std::min<size_t>(order[k + kPrefetchDistance], boxes.size() - 1)]);
    const uint32_t id = order[k];
    if (id >= boxes.size()) continue;
    items[stayed] = PackSortItem(SortableKey(boxes[id].min[axis]), id);
    stayed += rows_[id] == row ? 1 : 0;
  }
  const size_t arrivals = count - stayed;
  for (size_t k = 0; k < arrivals; ++k) {
    const uint32_t id = columns_.ids()[begin + stayed + k];
    items[stayed + k] = PackSortItem(SortableKey(boxes[id].min[axis]), id);
  }
  return stayed;
}

// Computes the first slots of the cells of one row.
void TracyLists::MarkCells(const GroupGrid& grid, uint32_t first_cell, size_t begin, size_t end,
                           Part& part) {
  const size_t axis = grid.AxisOf(0);
  const uint32_t cells = grid.cells[axis];
  part.cells.EnsureWithSpare(cells + 1);
  uint32_t* const behind = part.cells.data();
  std::fill_n(behind, cells + 1, static_cast<uint32_t>(begin));
  const float* const min = columns_.in_grids().min[axis];
  const float last = static_cast<float>(cells - 1);
  for (size_t slot = begin; slot < end; ++slot) {
    const float cell = (min[slot] * 0.5F - grid.origin[axis]) * grid.scale[axis];
    behind[static_cast<uint32_t>(std::min(std::max(cell, 0.0F), last)) + 1] =
        static_cast<uint32_t>(slot + 1);
  }
  uint32_t first = static_cast<uint32_t>(begin);
  for (uint32_t cell = 0; cell < cells; ++cell) {
    first = std::max(first, behind[cell]);
    starts_[first_cell + cell] = first;
  }
}

size_t TracyLists::native_bytes() const {
  size_t bytes = rows_.capacity_bytes() + order_.capacity_bytes() + first_slots_.capacity_bytes() +
                 old_slots_.capacity_bytes() + arrivals_.capacity_bytes() +
                 arrived_.capacity_bytes() + columns_.native_bytes() + starts_.capacity_bytes() +
                 parts_.capacity() * sizeof(Part);
  for (const Part& part : parts_) {
    bytes +=
        part.change.capacity_bytes() + part.items.capacity_bytes() + part.cells.capacity_bytes();
  }
  return bytes;
}

}  // namespace sweepstake
