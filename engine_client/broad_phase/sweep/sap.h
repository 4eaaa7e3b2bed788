// SAP, sweep and prune: sorts all boxes by their lower face on one axis, each frame anew, and tests
// each box only against those that begin before it ends there; first in bytes, 64 boxes to a
// register, then exactly what is left of that (byte_boxes.h).
//
// The axis is the one on which boxes take up the smallest share of the scene. One counting sort, by
// equal steps, eight boxes in the mean, orders them well enough for a sweep in steps; where many
// boxes share a step, a radix sort by the exact face.
//
// Cost: Build and Update O(n), 7 to 11 ns per box; FindPairs O(n + c + pairs), c = pairs that
// overlap on the sweep axis, about n^(5/3) at constant density. The reference suite's Brownian
// scene takes 0.016 ms with 1,000 boxes, 0.22 ms with 10,000 and 5.5 ms with 100,000 (2.9 ms with
// two threads): 64 checks in 0.9 ns on AVX-512, and 2 to 3 ns per pair. Long thin boxes: 10,000 of
// 40 : 1 take 0.4 ms. Memory: 55 bytes per box, 16 more where boxes share steps. Kept between
// frames: nothing but the buffers. aabb_check_count: c, rounded up
// to whole registers for each four boxes.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeSap(const BroadPhaseOptions& options);

}  // namespace sweepstake
