// The sweep over boxes in ascending order of their lower faces, which SAP and AxisSweep share.
#pragma once

#include <cstdint>

#include "engine_client/broad_phase/soa_boxes.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Appends every overlapping pair of `lanes` and returns the checks made. REQUIRES: lanes.min[0]
// ascends. Throws std::bad_alloc.
uint64_t SweepSorted(const BoxLanes& lanes, PairBuffer& out);

}  // namespace sweepstake
