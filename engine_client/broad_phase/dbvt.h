// DBVT: a dynamic bounding volume tree with margins, sixteen wide and kept between frames.
//
// While little moves, the tree holds every box enlarged by a margin, and the pairs of enlarged
// boxes that overlap are kept: a frame costs what left its margins (dbvt_margins.h). While much
// moves, the boxes of all objects are followed in place, every node has a margin by which it may
// stretch, and what stretches it further is put where it fits better (dbvt_tree.h); pairs are found
// leaf against tree, sixteen boxes at a time (dbvt_query.h). Which of the two it is follows from
// what moved in the latest frames. Where moving has made the tree worse, it is built anew from the
// order of recursive median splits (kd_order.h). Objects that come and go are inserted and removed;
// only when a frame brings half as many again is the tree built anew.
//
// Kept between frames: tree, and while little moves margins and candidate pairs, as long as there
// are no more than 16 pairs per object.
//
// Cost (one thread, suite-b at 10,000): 20 ns per object and frame where all move by a seventh of
// their size, 5 ns where they move by a thousandth. Memory: 84 bytes per object; where little moves
// 57 and 8 per candidate pair more.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options);

}  // namespace sweepstake
