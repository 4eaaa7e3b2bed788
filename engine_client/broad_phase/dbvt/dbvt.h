// DBVT: a dynamic bounding volume tree with margins, sixteen wide and kept between frames.
//
// It works in one of two modes, which it chooses by what moved in the latest frames:
//   At rest, while little moves: the tree holds every box enlarged by a margin, and the pairs of
//   enlarged boxes are kept, so that a frame costs only what left its margins (dbvt_margins.h).
//
//   In motion: every frame refits the boxes in place. A node may stretch up to its reach; what
//   stretches it further is inserted where it fits better (dbvt_tree.h). Pairs are found by testing
//   each leaf against the tree (dbvt_query.h).
//
// The tree is rebuilt from an order of median splits (kd_order.h) when the extra checks since the
// latest rebuild exceed its cost (rebuild_debt.h); the order is made over several frames. It is
// rebuilt at once where most leaves have lost their place, as when boxes teleport, and where a
// quarter of the objects come or go in one frame. Fewer of those are inserted and removed one by
// one.
//
// Kept between frames: the tree, and at rest the margins and candidate pairs, as long as there are
// at most 16 pairs per object.
//
// Cost (one thread of an AMD EPYC with AVX-512, ms per frame of 10,000 boxes with 1.4 pairs each):
// all move by a seventh of their size 0.16, by a thousandth 0.05; one in a hundred moves 0.05, none
// 0.04; a third teleports 0.38. 18 ns per box at 100,000, 28 at 1,000,000. Memory: 97 bytes per
// object; at rest 53 more, and 8 to 16 per candidate pair.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options);

}  // namespace sweepstake
