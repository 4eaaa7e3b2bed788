// BruteForce: every box against every other, the yardstick of the other families. First in bytes,
// 64 boxes to a register, then exactly what is left of that (byte_boxes.h).
//
// Cost: Build and Update O(n), 3 to 4 ns per box; FindPairs n²/2 checks plus O(pairs). The
// reference suite's Brownian scene takes 0.025 ms with 1,000 boxes, 0.13 ms with 3,000 and 0.86 ms
// with 10,000 (0.46 ms with two threads): 64 checks in 1 ns on AVX-512, and 2 to 3 ns per pair.
// Where the bytes cannot tell boxes apart each check takes 1.9 ns, as if all were pairs: 24 ms for
// 5,000 coincident boxes. Memory: 42 bytes per box. Kept between frames: nothing but the buffers.
// aabb_check_count: n²/2, rounded up to whole registers for each group of four boxes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeBruteForce(const BroadPhaseOptions& options);

}  // namespace sweepstake
