// Tracy: sweep and prune in the cells of a grid that is kept between frames (Tracy, Buss & Woods
// 2009, "Efficient Large-Scale Sweep and Prune Methods with AABB Insertion and Removal").
//
// The cells form rows along the sweep axis. Each row keeps a list of the boxes that begin in it,
// sorted by their begin on that axis. A box that crosses into another row is removed from its list
// and inserted into the other. An insertion sort restores the order of the rest, at a cost in
// proportion to the changes. Objects added or removed at the end are treated in the same way.
//
// A list is swept against itself and the rows around it. A box is tested against boxes that begin,
// on the sweep axis, before its end and at most the maximum side before its own begin. Boxes of
// different shapes have separate grids (grid_plan.h). A box that has outgrown the cells of its grid
// is tested against all boxes.
//
// If the boxes crowd in a few cells, a layout stretches the axes as in grid.h.
//
// While little moves, the lists hold boxes enlarged by a margin, and the pairs of enlarged boxes
// are kept. A frame then checks each box and each kept pair. It searches only for the boxes that
// have left their margins (tracy_rest.h). At most 16 pairs per box are kept.
//
// The lists, the row of each box and the grids are kept between frames. The grids are laid out
// again (as in Build) in three cases:
// - Too many boxes have outgrown their cells.
// - The checks in excess of the cheapest frame since the last layout add up to 256 per object.
// - A search makes far more checks than its number of pairs explains. The grids are then laid out
//   again at most every 64 frames.
//
// Cost: Build O(n log n); a frame O(n + boxes around a box + changes). Measured on AMD Zen 5 with
// AVX-512 and `sweepstake-lab bench`: in suite-b 23 ns per box from 1,000 to 100,000 boxes and 41
// ns at 1,000,000, in suite-h 25 to 33 ns, in suite-g 39 to 53 ns. Two threads are 1.6 times as
// fast at 10,000 boxes, 1.9 times at 100,000. Memory: 45 bytes per box and 4 per cell; 65 more
// while little moves, and 48 more with stretched axes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options);

}  // namespace sweepstake
