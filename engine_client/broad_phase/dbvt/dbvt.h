// DBVT: a dynamic bounding volume tree with margins, sixteen wide and kept between frames.
//
// It works in one of two modes and chooses between them by the motion in the latest frames:
// - At rest, while little moves, the tree holds every box enlarged by a margin, and the pairs of
//   enlarged boxes are kept. A frame then searches only for the boxes that have left their margins
//   (dbvt_margins.h).
// - In motion, every frame refits the boxes in place. A node may grow up to a size limit, its
//   reach. An entry that enlarges its node further is inserted again at a better place
//   (dbvt_tree.h). Pairs are found by testing each leaf against the tree (dbvt_query.h).
//
// The tree is rebuilt from an order of median splits (kd_order.h) when the extra checks since the
// latest rebuild exceed its cost (rebuild_debt.h). The order is computed over several frames. Two
// cases rebuild the tree at once: most leaves have grown beyond their reach, as when boxes
// teleport, or a quarter of the objects are added or removed in one frame. Fewer objects are
// inserted and removed one by one.
//
// Kept between frames: the tree, and at rest the margins and candidate pairs. The tree uses margins
// only with at most 16 pairs per object.
//
// Cost, measured with `sweepstake-lab bench` on one thread of AMD Zen 4: 10,000 boxes take 0.21 ms
// per frame in suite-b with AVX-512, 0.25 with AVX2 and 0.39 with SSE4. In suite-g they take 0.48,
// 0.65 and 0.99 ms. Memory: 97 bytes per object; at rest 53 more, and 8 to 16 per candidate pair.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options);

}  // namespace sweepstake
