// Lists of boxes, one per row of cells, that are kept between frames. They are sorted by the start
// of the boxes along the row.
//
// Update moves each box whose row has changed from its old list to the new one. An insertion sort
// restores the order of the other boxes, at a cost in proportion to the changes. The lists are
// stored in one array, one after the other.
//
// Not thread-safe. Owns its memory. Cost: O(n + changes). Memory: 40 bytes per box, 4 per cell, and
// 8 per row and part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/grid/grid_search.h"
#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/tracy/tracy_rows.h"
#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class TracyLists {
 public:
  // Makes empty lists for these grids.
  void Reset(const RowGrids& grids);
  // Moves boxes to their present rows, adds new objects, removes deleted ones, and restores the
  // order of the lists. Leaves room for `query_count` boxes of SearchFor. Polls `stop`, which may
  // be null; after a stop the lists are undefined.
  void Update(Executor* executor, const GridBoxes& boxes, size_t query_count = 0,
              StopRequest* stop = nullptr);

  // Changes the grids so that the boxes still fit them if they are enlarged by `margin` on each
  // side.
  void SetMargin(float margin);
  // Returns the shortest side of all cells. Along the rows, where cells are shorter, the side of
  // GroupGrid::kRowCells cells counts.
  float narrowest_cell() const;

  GridView View() const {
    return {columns_.lanes(),
            columns_.in_grids(),
            starts_.data(),
            {grids_.grids.data(), grids_.group_count},
            grids_.searches.data()};
  }
  // Removes an object's box from all searches until the next Update.
  void Invalidate(uint32_t object);
  // Appends the pairs of the boxes `ids` with one another and with boxes in the lists; returns the
  // number of AABB checks. `stop` may be null. REQUIRES: at most as many ids as the `query_count`
  // of the latest Update.
  uint64_t SearchFor(const GridBoxes& boxes, std::span<const uint32_t> ids, PairBuffer& out,
                     StopRequest* stop);

  // Returns the number of boxes in the lists.
  size_t size() const { return size_; }
  // Returns the number of boxes that are too long for the grid of their group.
  size_t long_count() const { return size_ - first_slots_[grids_.long_row()]; }
  // Returns the number of boxes that the latest Update moved to another list.
  size_t moved_count() const { return moved_count_; }
  size_t native_bytes() const;

 private:
  // The buffers of one part of the parallel loops. Each part has its own cache lines.
  struct alignas(64) Part {
    AlignedBuffer<int32_t> change;  // the change of each list's length
    AlignedBuffer<uint64_t> items;  // the items of one list (radix_sort.h)
    AlignedBuffer<uint32_t> cells;  // the first slots of one row's cells
    size_t begin = 0;               // the first box of the part
    size_t arrived = 0;  // the number of boxes in arrived_ from `begin` on; they have new rows
  };

  void MakeRoom(size_t count, size_t parts);
  void SetCount(size_t count);
  void MoveBoxes(std::span<const Aabb> boxes, Part& part, size_t end, StopRequest* stop);
  void PlaceLists(size_t parts);
  void SweepRow(const GridBoxes& boxes, uint32_t row, const GroupGrid& grid, uint32_t grid_row,
                Part& part);
  void PlaceArrivals(const Part& part, StopRequest* stop);
  void SweepRows(const GridBoxes& boxes, uint32_t begin, uint32_t end, Part& part,
                 StopRequest* stop);
  size_t CollectItems(std::span<const Aabb> boxes, uint32_t row, size_t axis, Part& part);
  void MarkCells(const GroupGrid& grid, uint32_t first_cell, size_t begin, size_t end, Part& part);

  RowGrids grids_;
  RowGrids grids_without_margin_;
  size_t count_ = 0;  // the number of objects
  size_t size_ = 0;
  size_t moved_count_ = 0;
  AlignedBuffer<uint32_t> rows_;         // the row of each object
  AlignedBuffer<uint32_t> order_;        // the lists before the latest Update
  AlignedBuffer<uint32_t> first_slots_;  // the first slot of each list, then size_
  AlignedBuffer<uint32_t> old_slots_;    // first_slots_ before the latest Update
  AlignedBuffer<uint32_t> arrivals_;     // the slot of the next new box in each list
  AlignedBuffer<uint32_t> arrived_;
  GridColumns columns_;
  AlignedBuffer<uint32_t> starts_;
  HookedVector<Part> parts_;
};

}  // namespace sweepstake
