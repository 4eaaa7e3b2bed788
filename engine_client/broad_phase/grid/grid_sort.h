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

// Boxes as six float columns, one stride apart, and their ids. The caller writes the id of each
// slot. grid_search.h reads this layout. Parts may gather disjoint ranges of slots at the same
// time. Memory: 28 bytes per slot.
class GridColumns {
 public:
  // Makes room for `count` slots with undefined content, and for a register that kernels may read
  // behind them.
  void Resize(size_t count);
  // Returns an array with the id of each slot's box. The caller writes the ids, and Gather reads
  // them.
  uint32_t* ids() { return ids_.data(); }
  const uint32_t* ids() const { return ids_.data(); }
  // Copies the box of each slot in [begin, end), boxes[ids()[slot]], to the columns.
  void Gather(std::span<const Aabb> boxes, size_t begin, size_t end);

  // Makes the box of the slot overlap nothing.
  void Invalidate(size_t slot);

  BoxLanes lanes() const;
  size_t native_bytes() const { return floats_.capacity_bytes() + ids_.capacity_bytes(); }

 private:
  AlignedBuffer<float> floats_;  // the columns min x, y, z, max x, y, z, each of stride_ floats
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
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
  void Sort(Executor* executor, std::span<const Aabb> boxes, std::span<const GroupGrid> grids,
            const GroupChoice& choice, StopRequest* stop = nullptr);

  // Returns the boxes in the order of the cells, then the invalid ones, then padding.
  BoxLanes lanes() const { return columns_.lanes(); }
  // starts()[c] is the first slot of cell c; the last element is the number of slots.
  const uint32_t* starts() const { return starts_.data(); }
  size_t native_bytes() const {
    return columns_.native_bytes() + keys_.capacity_bytes() + starts_.capacity_bytes() +
           part_counts_.capacity_bytes();
  }

 private:
  void MakeRoom(size_t parts);
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
