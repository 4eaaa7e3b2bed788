// DBVT: a dynamic bounding volume tree with margins, sixteen wide and kept between frames.
//
// While little moves, the tree holds every box enlarged by a margin, and the pairs of enlarged
// boxes that overlap are kept: a frame costs what left its margins (dbvt_margins.h). While much
// moves, the boxes of all objects are followed in place, every node has a margin by which it may
// stretch, and what stretches it further is put where it fits better (dbvt_tree.h); pairs are found
// leaf against tree, sixteen boxes at a time (dbvt_query.h). Which of the two it is follows from
// what moved in the latest frames. Where motion has made the tree worse, it is built anew from an
// order of recursive median splits that is made over several frames (kd_order.h); at once only
// where most leaves have lost their place, as when boxes teleport. Objects that come and go are
// inserted and removed; only a frame in which a quarter comes or goes has the tree built anew.
//
// Kept between frames: tree, and while little moves margins and candidate pairs, as long as there
// are no more than 16 pairs per object.
//
// Cost (one thread, ms per frame of 10,000 boxes with 1.4 pairs each): all move by a seventh of
// their size 0.16, by a thousandth 0.05, one in a hundred moves 0.05, none 0.04; a third teleports
// 0.38. 18 ns per box at 100,000, 28 at 1,000,000. Memory: 97 bytes per object; where little moves
// 53 more, and 8 to 16 per candidate pair.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options);

}  // namespace sweepstake
