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
// Kept between frames: lists, the row of each box, the grids. The grids are laid out anew (as in
// Build) when boxes outgrow them, when the checks above those of the cheapest frame since the last
// time add up to 256 per object, and now and then while a search makes far more checks than pairs.
// Cost: Build O(n log n); a frame O(n + boxes around a box + what has changed).
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options);

}  // namespace sweepstake
