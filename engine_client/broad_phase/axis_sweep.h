// AxisSweep, incremental sweep and prune: the faces of all boxes stay sorted on three axes between
// frames, and so does the set of overlapping pairs. Little motion makes few faces pass one another;
// only where a lower face passes an upper one can a pair begin or end.
//
// Two ways to bring the pairs up to date. Little motion: insertion sort repairs the three orders
// and each passing updates the pair set, O(n + passings). Much motion, by the share of neighbours
// out of order or by passings made: a passing costs more than starting over, so the three orders
// are sorted anew and a sweep along the widest axis finds the pairs as in SAP, O(n + c + pairs), c
// = pairs that overlap on that axis. Build sorts anew. The pair set is adopted from a sweep once
// motion is little, unless there are more than 32 pairs per box: then writing them is what costs
// either way.
//
// Memory: 120 bytes per box, and 16 to 48 per pair while the set is in use. Kept between frames:
// the three orders, the pair set. aabb_check_count: lanes of the sweep, and one per passing that
// may begin a pair.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeAxisSweep(const BroadPhaseOptions& options);

}  // namespace sweepstake
