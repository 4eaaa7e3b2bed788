// Sorts boxes by the cells of their grids with a counting sort, in parts if there are several
// threads.
//
// Boxes of one cell stay in the caller's order, so that the result does not depend on the parts.
// Not thread-safe. Owns its memory. Cost: O(n + cells). Memory: 36 bytes per box, 4 per cell, and 4
// per cell and part if there are several parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"

namespace sweepstake {

// The boxes of a frame, and the same boxes in the coordinates of the grids. Both are one array
// unless the axes are stretched (grid_plan.h).
struct GridBoxes {
  std::span<const Aabb> boxes;
  std::span<const Aabb> in_grids;

  bool is_stretched() const { return boxes.data() != in_grids.data(); }
  size_t size() const { return boxes.size(); }
};

// Boxes as six float columns, one stride apart, and their ids. The caller writes the id of each
// slot. grid_search.h reads this layout. Parts may gather disjoint ranges of slots at the same
// time. Memory: 28 bytes per slot, and 24 more with stretched axes.
class GridColumns {
 public:
  // Makes room for `count` slots with undefined content, and for a register that kernels may read
  // behind them. `is_stretched` says whether the boxes to gather are stretched too.
  void Resize(size_t count, bool is_stretched);
  // Returns an array with the id of each slot's box. The caller writes the ids, and Gather reads
  // them.
  uint32_t* ids() { return ids_.data(); }
  const uint32_t* ids() const { return ids_.data(); }
  // Copies the box of each slot in [begin, end), number ids()[slot], to the columns.
  void Gather(const GridBoxes& boxes, size_t begin, size_t end);

  // Makes the box of the slot overlap nothing.
  void Invalidate(size_t slot);

  // Return the boxes, and the boxes in the coordinates of the grids.
  BoxLanes lanes() const { return LanesOf(floats_); }
  BoxLanes in_grids() const { return LanesOf(is_stretched_ ? stretched_ : floats_); }
  size_t native_bytes() const {
    return floats_.capacity_bytes() + stretched_.capacity_bytes() + ids_.capacity_bytes();
  }

 private:
  BoxLanes LanesOf(const AlignedBuffer<float>& floats) const;
  void GatherInto(AlignedBuffer<float>& floats, std::span<const Aabb> boxes, size_t begin,
                  size_t end);

  AlignedBuffer<float> floats_;     // the columns min x, y, z, max x, y, z, each of stride_ floats
  AlignedBuffer<float> stretched_;  // the same for the stretched boxes
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
  bool is_stretched_ = false;
};

// Maps the shape class of a box to its group. Each group has its own grid.
struct GroupChoice {
  ShapeClasses classes;
  uint32_t group_of_class[ShapeClasses::kCount];
};

class GridSort {
 public:
  // Sorts the boxes by the cells of their min corners. Polls `stop`, which may be null; after a
  // stop the order is undefined. REQUIRES: the cell numbers of the grids are consecutive, starting
  // at 0.
  void Sort(Executor* executor, const GridBoxes& boxes, std::span<const GroupGrid> grids,
            const GroupChoice& choice, StopRequest* stop = nullptr);

  // Returns the boxes in the order of the cells, then the invalid ones, then padding.
  const GridColumns& columns() const { return columns_; }
  // starts()[c] is the first slot of cell c; the last element is the number of slots.
  const uint32_t* starts() const { return starts_.data(); }
  size_t native_bytes() const {
    return columns_.native_bytes() + keys_.capacity_bytes() + starts_.capacity_bytes() +
           part_counts_.capacity_bytes();
  }

 private:
  void MakeRoom(size_t parts, bool is_stretched);
  void CountInParts(Executor* executor, size_t parts, std::span<const Aabb> boxes,
                    std::span<const GroupGrid> grids, const GroupChoice& choice, StopRequest* stop);
  void SumCounts(size_t parts);
  size_t FirstCellOfPart(size_t part, size_t parts) const;
  bool Place(size_t begin, size_t end, StopRequest* stop);

  AlignedBuffer<uint32_t> keys_;
  AlignedBuffer<uint32_t> starts_;
  AlignedBuffer<uint32_t> part_counts_;
  GridColumns columns_;
  size_t count_ = 0;
  size_t cells_ = 0;  // the number of cells, including one for invalid boxes
};

}  // namespace sweepstake
