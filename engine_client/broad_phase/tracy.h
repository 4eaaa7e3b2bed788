// Tracy: sweep and prune in the cells of a coarse grid (Tracy, Buss & Woods 2009, "Efficient
// Large-Scale Sweep and Prune Methods with AABB Insertion and Removal").
//
// Each cell keeps a list of the boxes that reach into it, sorted by where they begin on the sweep
// axis. The lists live between frames: a box that crosses into a cell is inserted, one that has
// left is removed when the list is next swept, and the order is restored by insertion, which costs
// as much as has changed. A pair that shares several cells is reported in the one that holds the
// greater of the two min corners, axis by axis. A box over more than 64 cells is "large": in no
// list, tested against every box.
//
// Kept between frames: lists, cell ranges, boxes, the grid. The grid is laid out anew (as in Build)
// before an Update when the checks above those of the cheapest frame since it was laid out add up
// to 256 per object. Cost: Build O(n log n); a frame O(n + entries + boxes that share a cell and
// overlap on the sweep axis + large · n). Memory: 72 bytes per object and 15 per
// entry; an object has 1.5 to 3 entries.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options);

}  // namespace sweepstake
