// BruteForce: every box against every other, the yardstick of the other families.
//
// Cost: Build and Update O(n); FindPairs n²/2 checks plus O(pairs), four boxes per load and a
// register of boxes per comparison. Memory: 28 bytes per box. Kept between frames: nothing but the
// buffers. aabb_check_count: n²/2, rounded up to whole registers for each group of four boxes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeBruteForce(const BroadPhaseOptions& options);

}  // namespace sweepstake
