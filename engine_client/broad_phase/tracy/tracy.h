// Tracy: sweep and prune in the cells of a grid that lives between frames (Tracy, Buss & Woods
// 2009, "Efficient Large-Scale Sweep and Prune Methods with AABB Insertion and Removal").
//
// The cells are rows that run through the scene along the sweep axis. Each keeps a list of the
// boxes that begin in it, sorted by where they begin on that axis. A box that crosses into another
// row is removed from its list and inserted into the other; the order of the rest is restored by
// insertion, which costs as much as has changed. Objects that come and go at the end are inserted
// and removed in the same way. A list is swept against itself and the rows around it: each box is
// tested against those that begin no further along than it ends, and no further back than the
// longest box reaches. Boxes of unlike shapes have grids of their own (grid_plan.h). A box that has
// outgrown its grid is tested against all.
//
// While little moves, the lists hold boxes enlarged by a margin, the pairs of those are kept, and a
// frame costs what has left its margin besides a look at each box and each kept pair
// (tracy_rest.h).
//
// Kept between frames: lists, the row of each box, the grids. The grids are laid out anew (as in
// Build) when boxes outgrow them, when the checks above those of the cheapest frame since the last
// time add up to 256 per object, and now and then while a search makes far more checks than pairs.
// Cost: Build O(n log n); a frame O(n + boxes around a box + what has changed). In suite-b 23 ns
// per box from 1,000 to 100,000 boxes and 41 ns at 1,000,000, in suite-h 25 to 33 ns, in
// suite-g 39 to 53 ns; 6 ns where boxes move by a thousandth. Two threads: 1.6 times as fast at
// 10,000 boxes, 1.9 times at 100,000.
// Memory: 45 bytes per box and 4 per cell; while little moves 65 more.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options);

}  // namespace sweepstake
