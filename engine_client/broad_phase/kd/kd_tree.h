// KDTree: boxes in the order of recursive median splits, in leaves of sixteen below an implicit
// 16-wide tree.
//
// Where to read: kd_order.h makes the order and kd_split.h its splits. leaf_tree.h is the tree.
// kd_search.cc and leaf_search-inl.h search for pairs.
//
// Making the order costs more than finding the pairs in it. The order is therefore kept while it is
// good, and a frame only refits the bounds of leaves and nodes. Making a new order is called a
// split. A split begins when the extra checks since the latest one exceed its cost
// (rebuild_debt.h): about every 30 frames in suite-b, never in a scene at rest. It is spread over
// up to six frames and runs in parallel with their searches, so that no frame takes twice the usual
// time. If a search costs more than a split, the split is made at once. If the leaves have grown to
// four times their volume (all boxes have jumped), the boxes are split before the search.
//
// Removed boxes leave holes, and new ones get separate leaves behind the others. A split is due
// when holes and new boxes are a sixteenth of all slots.
//
// Kept between frames: the order, and a split in progress. Cost: Build O(n log n); a frame O(n +
// leaves · log n + candidates + pairs). Measured with `sweepstake-lab bench` on one thread of AMD
// Zen 4 with AVX-512: 0.013 ms for 1,000 boxes of suite-b, 0.16 for 10,000, 1.7 for 100,000; 0.40
// for 10,000 of suite-g. With AVX2, 10,000 boxes take 0.18 ms in suite-b and 0.49 in suite-g.
// Memory: 75 bytes per box. With an Executor, the refit runs in parts of 2,048 boxes or more, and
// the search in parts of 1,024 or more.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeKdTree(const BroadPhaseOptions& options);

}  // namespace sweepstake
