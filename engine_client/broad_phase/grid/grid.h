// Grid: uniform grids, one per group of alike shapes, sorted anew each frame by a counting sort.
//
// A box is kept once, in the cell of its min corner in the grid of its group, and finds its
// partners in the rows of cells around it: half of those of its own grid, so that a pair is found
// once, and all of the other groups' where its group is the one to look. Boxes of one size are one
// group and one grid. Where sizes differ, by levels or by axis, groups keep a few huge boxes from
// making the cells of the small ones large, and let long thin boxes have long thin cells. Which
// shapes share a group is chosen by estimated cost (grid_cost.h) from the boxes there are, so that
// neither sizes nor outliers decide how the rest is divided.
//
// Kept between frames: memory and the choice of groups. Cost: O(n + cells) for the sort and
// O(n · boxes around a box) for the search; cells <= 4 n + 256 per group. In suite-b 18 to 19 ns
// per box from 1,000 to 100,000 boxes and 31 ns at 1,000,000, in suite-h 20 to 21 ns, in suite-g 32
// to 40 ns; needles of 1:100 along all axes 38 ns, sizes over three decades 32 ns. Two threads: 1.5
// times as fast at 10,000 boxes, 1.75 times at 100,000. Memory: 32 bytes per box and 8 per cell.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options);

}  // namespace sweepstake
