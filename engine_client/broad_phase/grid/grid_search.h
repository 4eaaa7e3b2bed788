// Finds the pairs of boxes that are stored in the order of their grids' cells.
//
// Each box is tested against later boxes of its own group and against boxes of the groups that its
// group searches (GridView::searches). The search reads rows of cells; the boxes of a row are in
// consecutive slots. For a batch of boxes, it first lists the ranges of slots to test, and then
// tests them. Testing each range when it is found would cost a mispredicted branch per row.
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

// The number of tests that take as long as reading one more row of cells.
inline constexpr uint32_t kTestsPerRow = 10;

struct GridView {
  // The number of slots in a batch; parts of a search begin at multiples of it.
  static constexpr size_t kBatch = 256;

  BoxLanes lanes;          // the boxes in the order of the cells
  BoxLanes in_grids;       // the same in the coordinates of the grids (GridPlan::InGrids)
  const uint32_t* starts;  // the first slot of each cell, then the number of slots
  std::span<const GroupGrid> grids;
  // If bit h of searches[g] is set, boxes of group g search group h.
  const uint32_t* searches;
};

// Searches for the boxes in the slots [begin, end): appends their pairs and returns the number of
// AABB checks. Each pair is found by one of its two boxes. If `begin` is a multiple of kBatch, the
// pairs are in the same order as in a search over all slots. Polls `stop`, which may be null,
// between batches and after many pairs have been written.
uint64_t SearchGrids(const GridView& view, size_t begin, size_t end, PairBuffer& out,
                     StopRequest* stop);

}  // namespace sweepstake
