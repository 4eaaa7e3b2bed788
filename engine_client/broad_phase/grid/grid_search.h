// Finds the pairs of boxes that are stored in the order of their grids' cells.
//
// A box searches the later boxes of its own group and all boxes of the groups that its group
// searches, row by row of cells. A row is a range of slots. The ranges of a batch of boxes are
// listed first and tested afterwards. This avoids a mispredicted branch for the rows that a box
// reaches.
//
// Not thread-safe. Borrows everything for the call. Memory: 34 KiB on the stack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

struct GridView {
  // The number of slots searched at a time; parts of a search begin at multiples of it.
  static constexpr size_t kBatch = 256;

  BoxLanes lanes;          // the boxes in the order of the cells
  const uint32_t* starts;  // the first slot of each cell, then the number of slots
  std::span<const GroupGrid> grids;
  // If bit h of searches[g] is set, boxes of group g search group h.
  const uint32_t* searches;
};

// Appends the pairs that the boxes in the slots [begin, end) find and returns the number of AABB
// checks. Parts that begin at multiples of kBatch find the pairs in the same order as a search over
// all slots. Polls `stop`, which may be null, between batches and after many pairs have been
// written.
uint64_t SearchGrids(const GridView& view, size_t begin, size_t end, PairBuffer& out,
                     StopRequest* stop);

}  // namespace sweepstake
