// KDTree: boxes in the order of recursive median splits, in leaves of one register, below an
// implicit 16-wide tree.
//
// The order costs several times as much as finding the pairs in it, so it is kept while it is good:
// each frame only the bounds of leaves and nodes are refitted. The boxes are split anew before an
// Update when the checks made above those of the cheapest frame since the last split add up to 128
// per object, about what a split costs: every 8 frames or so where everything moves, never where
// everything rests.
//
// Kept between frames: the order. Cost: Build O(n log n); a frame O(n + leaves · log n +
// candidates), and O(n log n) in frames that split. Memory: 55 bytes per object.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeKdTree(const BroadPhaseOptions& options);

}  // namespace sweepstake
