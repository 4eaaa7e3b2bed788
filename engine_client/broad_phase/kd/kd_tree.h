// KDTree: boxes in the order of recursive median splits, in leaves of sixteen, below an implicit
// 16-wide tree.
//
// The order costs twice as much as finding the pairs in it, so it is kept while it is good: each
// frame only the bounds of leaves and nodes are refitted. A new split begins when the checks made
// above those of the cheapest frame since the last one add up to 105 per box, about what a split
// costs: every 30 frames or so in suite-b, never where everything rests. It is made beside the
// searches of up to six frames, so that no frame costs twice the usual, and at once where a search
// costs more than a split. Where the leaves have grown to four times their volume since the last
// split (everything has jumped), the boxes are split before the search.
//
// Boxes that are gone leave holes, new ones get leaves of their own behind the others; the next
// split, due when they are a sixteenth of all, takes them in.
//
// Kept between frames: the order, and a split under way. Cost: Build O(n log n), 20 to 25 ns per
// box up to 100,000; a frame O(n + leaves · log n + candidates + pairs): 0.009 ms for 1,000 boxes
// of suite-b, 0.11 for 10,000, 1.2 for 100,000, 20 for 1,000,000; 0.27 for 10,000 of suite-g. Where
// everything jumps, 0.28 for 10,000. Memory: 75 bytes per box. With an Executor gathering and the
// search run in parts of 32,768 and 1,024 boxes, and a step of a split beside the search.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeKdTree(const BroadPhaseOptions& options);

}  // namespace sweepstake
