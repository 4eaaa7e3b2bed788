// Lists of boxes, one per row of cells, that live between frames: sorted by where the boxes begin
// along the row.
//
// Boxes that have come are inserted and those that have left are removed when the lists are next
// swept; the order of the others is restored by insertion, which costs as much as has changed. The
// lists lie one after the other in one array, so that they are swept as one.
//
// Not thread-safe. Owns its memory. Cost: O(n + what has changed), 9 ns per box of suite-b. Memory:
// 40 bytes per box, 4 per cell, and 8 per row and part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/grid/grid_columns.h"
#include "engine_client/broad_phase/grid/grid_search.h"
#include "engine_client/broad_phase/tracy/tracy_rows.h"
#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class TracyLists {
 public:
  // Empty lists for these grids.
  void Reset(const RowGrids& grids);
  // Moves boxes to the rows they are in now, takes in those that are new and drops those that are
  // no more, and restores the order. Leaves room for `guests` of SearchFor.
  void Update(Executor* executor, std::span<const Aabb> boxes, size_t guests = 0);

  // Boxes that are enlarged by so much on each side still fit into their grids.
  void SetMargin(float margin);
  // Across the rows, the narrowest of all.
  float narrowest_cell() const;

  GridView View() const {
    return {columns_.lanes(),
            starts_.data(),
            {grids_.grids.data(), grids_.group_count},
            grids_.looks_into.data()};
  }
  // Takes the box of an object out of the search until the next Update.
  void Blind(uint32_t object);
  // Appends the pairs of these boxes (slot k holds id ids[k]) with one another and with those in
  // the lists; returns the AABB checks. REQUIRES: as many as Update left room for.
  uint64_t SearchFor(std::span<const Aabb> boxes, std::span<const uint32_t> ids, PairBuffer& out);

  // Boxes in lists.
  size_t size() const { return size_; }
  // Those of them that are too long for the grid of their group.
  size_t long_count() const { return size_ - first_slots_[grids_.long_row()]; }
  // Boxes that the latest Update put into another list than before.
  size_t moved_count() const { return moved_count_; }
  size_t native_bytes() const;

 private:
  // What a part of the work needs for itself. A cache line each.
  struct alignas(64) Part {
    AlignedBuffer<int32_t> change;  // of the length of each list
    AlignedBuffer<uint64_t> items;  // of one list (radix_sort.h)
    AlignedBuffer<uint32_t> cells;  // first slots of one row
    size_t begin = 0;               // boxes
    size_t arrived = 0;             // of them, listed in arrived_ from `begin` on
  };

  size_t PartsFor(const Executor* executor, size_t count) const;
  void MakeRoom(size_t count, size_t parts);
  void Forget(size_t count);
  void MoveBoxes(std::span<const Aabb> boxes, Part& part, size_t end);
  void PlaceLists(size_t parts);
  void SweepRow(std::span<const Aabb> boxes, uint32_t row, const GroupGrid& grid, uint32_t grid_row,
                Part& part);
  void SweepRows(std::span<const Aabb> boxes, uint32_t begin, uint32_t end, Part& part);
  size_t TakeItems(std::span<const Aabb> boxes, uint32_t row, size_t axis, Part& part);
  void MarkCells(const GroupGrid& grid, uint32_t first_cell, size_t begin, size_t end, Part& part);

  RowGrids grids_;
  RowGrids grids_without_margin_;
  size_t count_ = 0;  // objects
  size_t size_ = 0;
  size_t moved_count_ = 0;
  AlignedBuffer<uint32_t> rows_;         // of each object
  AlignedBuffer<uint32_t> order_;        // the lists before the latest Update
  AlignedBuffer<uint32_t> first_slots_;  // of the lists; one more at the end
  AlignedBuffer<uint32_t> old_slots_;    // the same before the latest Update
  AlignedBuffer<uint32_t> arrivals_;     // per list: where the next box that has come is put
  AlignedBuffer<uint32_t> arrived_;
  GridColumns columns_;
  AlignedBuffer<uint32_t> starts_;
  std::vector<Part> parts_;
};

}  // namespace sweepstake
