// Grid: a uniform grid, rebuilt each frame by a counting sort.
//
// A box belongs to the cell of its min corner, and cells are no smaller than an ordinary box, so
// that partners are in the same or an adjacent cell; each box looks at half of those cells —
// itself, and the five rows of cells behind it — and so meets every partner once. A box that
// reaches beyond the next cell is "large" and tested against every box. The size up to which boxes
// are ordinary is chosen each frame from the sizes there are, so that neither one huge box nor a
// few outliers decide how the rest is divided.
//
// Kept between frames: nothing but memory. Cost: O(n + cells) for the sort and O(n · boxes around a
// box + large · n) for the search; cells ≤ 8 n + 512. Memory: 65 bytes per object + 4 per cell.
#pragma once

#include <memory>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options);

}  // namespace sweepstake
