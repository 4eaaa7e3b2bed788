// DBVT: a dynamic bounding volume tree with fattened leaves, kept between frames.
//
// Every box sits in the tree enlarged by a margin, and the pairs of enlarged boxes that overlap
// ("candidates") are kept as a list. A box that stays inside its enlarged one costs a comparison;
// one that leaves it is reinserted near where it was and asked for its candidates anew. FindPairs
// tests the exact boxes of the candidates, so the margin is never seen outside. Where more than a
// twentieth of the boxes leave at once, the tree is refitted as a whole (after 8 such frames' worth
// of moves split anew by medians) and all candidates are found afresh, sixteen leaves in the tree's
// order at a time (leaf_tree.h).
//
// Margin: four frames of the box's own motion, at least 2 % and at most 30 % of the median longest
// side of all boxes; a box that outruns the most in one frame gets the least, since no margin would
// hold it.
//
// Kept between frames: tree, candidates, exact boxes. Cost: Build O(n log n + candidates); a frame
// O(n) comparisons + O((log n + its candidates) per box that left) + O(candidates) exact tests. A
// frame in which all move O(n log n + candidates). Memory: 205 bytes per object + 8 per candidate
// (1 to 4 times the pairs).
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options);

}  // namespace sweepstake
