// SAP, sweep and prune: sorts all boxes by their lower face on the axis of largest spread, each
// frame anew, and tests each box only against those that begin before it ends on that axis.
//
// Cost: Build and Update O(n) (radix sort); FindPairs O(n + c + pairs), c = pairs that overlap on
// the sweep axis, about n^(5/3) at constant density: a register of boxes per comparison, four boxes
// per load. Memory: 48 bytes per box. Kept between frames: nothing but the buffers.
// aabb_check_count: c, rounded up to whole registers for each four boxes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeSap(const BroadPhaseOptions& options);

}  // namespace sweepstake
