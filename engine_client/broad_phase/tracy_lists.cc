#include "engine_client/broad_phase/tracy_lists.h"

#include <algorithm>

#include "engine_client/broad_phase/parallel.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "hwy/cache_control.h"

namespace sweepstake {
namespace {

constexpr size_t kMostParts = 8;
constexpr size_t kLeastBoxesPerPart = 2048;
// Boxes whose rows are found at a time: they stay in the first cache.
constexpr size_t kBatch = 512;
// Shifts per entry after which a list counts as unsorted.
constexpr size_t kShiftsPerEntry = 8;
// Entries ahead of the one being read: enough to hide the memory behind the last cache.
constexpr size_t kAhead = 16;

template <typename Entry>
bool Before(const Entry& a, const Entry& b) {
  return a.key < b.key || (a.key == b.key && a.id < b.id);
}

// Insertion, since the list was in order a frame ago; it gives up where that is no longer so.
template <typename Entry>
void SortEntries(Entry* entries, size_t count) {
  size_t shifts = 0;
  for (size_t i = 1; i < count; ++i) {
    const Entry entry = entries[i];
    size_t at = i;
    for (; at > 0 && Before(entry, entries[at - 1]); --at) entries[at] = entries[at - 1];
    entries[at] = entry;
    shifts += i - at;
    if (shifts > kShiftsPerEntry * count) {
      std::sort(entries, entries + count, Before<Entry>);
      return;
    }
  }
}

// Two sorted runs, of which the second is short, into one; `from` is a copy of the second.
template <typename Entry>
void MergeEntries(Entry* entries, size_t first, const Entry* from, size_t second) {
  size_t to = first + second;
  while (second > 0) {
    const bool later = first > 0 && Before(from[second - 1], entries[first - 1]);
    entries[--to] = later ? entries[--first] : from[--second];
  }
}

}  // namespace

void TracyLists::Reset(const RowGrids& grids) {
  grids_ = grids;
  count_ = 0;
  size_ = 0;
  first_slots_.EnsureDiscarding(grids_.row_count() + 1);
  std::fill_n(first_slots_.data(), grids_.row_count() + 1, 0U);
}

size_t TracyLists::PartsFor(const Executor* executor, size_t count) const {
  if (executor == nullptr) return 1;
  return std::clamp<size_t>(count / kLeastBoxesPerPart, 1,
                            std::min(executor->thread_count(), kMostParts));
}

void TracyLists::MakeRoom(size_t count, size_t parts) {
  const size_t rows = grids_.row_count();
  const size_t cells = grids_.grids[grids_.group_count - 1].last_cell() + 1;
  rows_.EnsureKeeping(count + SoaBoxes::kPadding, count_);
  arrived_.EnsureDiscarding(count + SoaBoxes::kPadding);
  old_slots_.EnsureDiscarding(rows + 1);
  arrivals_.EnsureDiscarding(rows);
  starts_.EnsureDiscarding(cells + 1);
  if (parts_.size() < parts) parts_.resize(parts);
  for (size_t part = 0; part < parts; ++part) {
    parts_[part].change.EnsureDiscarding(rows);
    std::fill_n(parts_[part].change.data(), rows, 0);
  }
}

// Objects from `count` on are no more; new ones are in no row yet.
void TracyLists::Forget(size_t count) {
  for (size_t i = count; i < count_; ++i) {
    if (rows_[i] != kNoRow) --parts_[0].change[rows_[i]];
  }
  if (count > count_) std::fill(rows_.data() + count_, rows_.data() + count, kNoRow);
  count_ = count;
}

void TracyLists::Update(Executor* executor, std::span<const Aabb> boxes) {
  const size_t parts = PartsFor(executor, boxes.size());
  // The lists as they are, before their places are taken by what they become.
  order_.EnsureDiscarding(std::max(boxes.size(), size_) + SoaBoxes::kPadding);
  std::copy_n(columns_.ids(), size_, order_.data());
  MakeRoom(boxes.size(), parts);
  Forget(boxes.size());
  RunParts(executor, parts, [&](size_t index) {
    const PartRange range = RangeOfPart(boxes.size(), index, parts, SoaBoxes::kPadding);
    parts_[index].begin = range.begin;
    MoveBoxes(boxes, parts_[index], range.end);
  });
  PlaceLists(parts);
  columns_.Resize(size_);
  for (size_t index = 0; index < parts; ++index) {
    const Part& part = parts_[index];
    for (size_t k = part.begin; k < part.begin + part.arrived; ++k) {
      columns_.ids()[arrivals_[rows_[arrived_[k]]]++] = arrived_[k];
    }
  }
  RunParts(executor, parts, [&](size_t index) {
    const uint32_t* const slots = first_slots_.data();
    const uint32_t* const end = slots + grids_.row_count();
    const auto border = [&](size_t k) {
      if (k == parts) return grids_.row_count();
      const auto slot = static_cast<uint32_t>(size_ * k / parts);
      return static_cast<uint32_t>(k == 0 ? 0 : std::lower_bound(slots, end, slot) - slots);
    };
    SweepRows(boxes, border(index), border(index + 1), parts_[index]);
  });
  starts_[grids_.grids[grids_.group_count - 1].last_cell()] = static_cast<uint32_t>(size_);
}

// The boxes [part.begin, end): which have moved from list to list.
void TracyLists::MoveBoxes(std::span<const Aabb> boxes, Part& part, size_t end) {
  uint32_t moved[kBatch + SoaBoxes::kPadding];
  uint32_t new_rows[kBatch + SoaBoxes::kPadding];
  int32_t* const change = part.change.data();
  size_t arrived = part.begin;
  for (size_t begin = part.begin; begin < end; begin += kBatch) {
    const size_t count = FindMoved(boxes.subspan(begin, std::min(kBatch, end - begin)), grids_,
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

// Where the lists begin now, and where in them what has arrived is put: behind what has stayed.
void TracyLists::PlaceLists(size_t parts) {
  std::swap(first_slots_, old_slots_);
  const uint32_t rows = grids_.row_count();
  first_slots_.EnsureDiscarding(rows + 1);
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

void TracyLists::SweepRows(std::span<const Aabb> boxes, uint32_t begin, uint32_t end, Part& part) {
  for (size_t group = 0; group < grids_.group_count; ++group) {
    const GroupGrid& grid = grids_.grids[group];
    const uint32_t first_row = grids_.row_grids[group].first_cell;
    const uint32_t last_row = first_row + grid.cells[grid.AxisOf(1)] * grid.cells[grid.AxisOf(2)];
    for (uint32_t row = std::max(begin, first_row); row < std::min(end, last_row); ++row) {
      SweepRow(boxes, row, grid, row - first_row, part);
    }
  }
}

void TracyLists::SweepRow(std::span<const Aabb> boxes, uint32_t row, const GroupGrid& grid,
                          uint32_t grid_row, Part& part) {
  const uint32_t begin = first_slots_[row];
  const uint32_t end = first_slots_[row + 1];
  const size_t count = end - begin;
  if (count > 0) {
    const size_t stayed = TakeEntries(boxes, row, grid.AxisOf(0), part);
    Entry* const entries = part.entries.data();
    SortEntries(entries, stayed);
    if (stayed < count) {
      SortEntries(entries + stayed, count - stayed);
      std::copy(entries + stayed, entries + count, entries + count);
      MergeEntries(entries, stayed, entries + count, count - stayed);
    }
    for (size_t k = 0; k < count; ++k) columns_.ids()[begin + k] = entries[k].id;
    columns_.Gather(boxes, begin, end);
  }
  const uint32_t row_cells = grid.cells[grid.AxisOf(0)];
  MarkCells(grid, grid.first_cell + grid_row * row_cells, begin, end, part);
}

// Those that have stayed, in the order of the list; behind them those that have come. Returns the
// number of the former.
size_t TracyLists::TakeEntries(std::span<const Aabb> boxes, uint32_t row, size_t axis, Part& part) {
  const size_t begin = first_slots_[row];
  const size_t count = first_slots_[row + 1] - begin;
  const size_t old_begin = old_slots_[row];
  const size_t old_end = old_slots_[row + 1];
  part.entries.EnsureDiscarding(std::max(2 * count, old_end - old_begin) + 1);
  Entry* const entries = part.entries.data();
  const uint32_t* const order = order_.data();
  size_t stayed = 0;
  for (size_t k = old_begin; k < old_end; ++k) {
    hwy::Prefetch(&boxes[std::min<size_t>(order[k + kAhead], boxes.size() - 1)]);
    const uint32_t id = order[k];
    if (id >= boxes.size()) continue;
    entries[stayed] = {boxes[id].min[axis], id};
    stayed += rows_[id] == row ? 1 : 0;
  }
  const size_t arrivals = count - stayed;
  for (size_t k = 0; k < arrivals; ++k) {
    const uint32_t id = columns_.ids()[begin + stayed + k];
    entries[stayed + k] = {boxes[id].min[axis], id};
  }
  return stayed;
}

// First slots of the cells of one row.
void TracyLists::MarkCells(const GroupGrid& grid, uint32_t first_cell, size_t begin, size_t end,
                           Part& part) {
  const size_t axis = grid.AxisOf(0);
  const uint32_t cells = grid.cells[axis];
  part.cells.EnsureDiscarding(cells + 1);
  uint32_t* const behind = part.cells.data();
  std::fill_n(behind, cells + 1, static_cast<uint32_t>(begin));
  const float* const min = columns_.lanes().min[axis];
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
        part.change.capacity_bytes() + part.entries.capacity_bytes() + part.cells.capacity_bytes();
  }
  return bytes;
}

}  // namespace sweepstake
