// Grid: uniform grids, one for each group of boxes of similar shape. A counting sort rebuilds them
// in each frame.
//
// A box is stored once, in the cell of its min corner in the grid of its group. It finds its pairs
// in the rows of cells around it. In its own grid it searches half of these rows, so that each pair
// is found once. Pairs of boxes of two groups are found from one side: the boxes of one of the two
// groups search all rows around them in the other group's grid. Boxes of one size form one group
// and one grid. If sizes differ, groups prevent a few huge boxes from enlarging the cells of the
// small ones, and give long thin boxes long thin cells. The estimated cost for the present boxes
// (grid_cost.h) decides which shapes share a group.
//
// If the boxes crowd in a few cells, such as in crowds that are far apart or with exponential
// spacing, the axes are stretched where many boxes are (axis_stretch.h). The cells of the stretched
// grid are narrow in the crowds and wide between them. This takes 5 to 20 ns more per box.
//
// Memory and the choice of groups are kept between frames. Cost: O(n + cells) for the sort and O(n
// · boxes around a box) for the search; cells <= 4 n + 256 per group. Measured on AMD Zen 5 with
// AVX-512 and `sweepstake-lab bench`. In suite-b: 18 to 19 ns per box from 1,000 to 100,000 boxes,
// 31 ns at 1,000,000. In suite-h: 20 to 21 ns. In suite-g: 32 to 40 ns. Two threads are 1.5 times
// as fast at 10,000 boxes, 1.75 times at 100,000. Memory: 32 bytes per box and 8 per cell; 48 more
// per box with stretched axes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options);

}  // namespace sweepstake
