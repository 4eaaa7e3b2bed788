// BruteForce tests every box against every other. It is the reference for the other backends. It
// first compares coordinates rounded to bytes, 64 boxes per AVX-512 register, and then tests the
// remaining candidates exactly (byte_boxes.h).
//
// Cost: Build and Update O(n), FindPairs n²/2 checks plus O(pairs). Measured on AMD Zen 5 with
// AVX-512 (`sweepstake-lab bench --scene suite-b`): 0.025 ms for 1,000 boxes, 0.13 ms for 3,000 and
// 0.86 ms for 10,000 (0.46 ms with two threads). 64 checks take 1 ns, writing a pair takes 2 to 3
// ns. If all boxes round to the same bytes, each check takes 1.9 ns: 24 ms for 5,000 boxes of the
// scene all-coincident. Memory: 42 bytes per box. The buffers and the number of pairs are kept
// between frames. aabb_check_count is n²/2, rounded up: four boxes at a time are compared with a
// whole number of registers of other boxes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeBruteForce(const BroadPhaseOptions& options);

}  // namespace sweepstake
