// Grid: uniform grids, one per group of boxes of similar shape, sorted in each frame by a counting
// sort.
//
// A box is stored once, in the cell of its min corner in the grid of its group. It finds its
// partners in the rows of cells around it: in half of those of its own grid, so that a pair is
// found once, and in all of those of the other groups that its group searches. Boxes of one size
// form one group and one grid. If sizes differ, groups prevent a few huge boxes from enlarging the
// cells of the small ones, and give long thin boxes long thin cells. The estimated cost
// (grid_cost.h) of the present boxes decides which shapes share a group, so that neither sizes nor
// outliers determine the cells of the rest.
//
// Memory and the choice of groups are kept between frames. Cost: O(n + cells) for the sort and O(n
// · boxes around a box) for the search; cells <= 4 n + 256 per group. Measured on AMD Zen 5 with
// AVX-512 and `sweepstake bench`: in suite-b 18 to 19 ns per box from 1,000 to 100,000 boxes and 31
// ns at 1,000,000, in suite-h 20 to 21 ns, in suite-g 32 to 40 ns; two threads are 1.5 times as
// fast at 10,000 boxes, 1.75 times at 100,000. Memory: 32 bytes per box and 8 per cell.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options);

}  // namespace sweepstake
