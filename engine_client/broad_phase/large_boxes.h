// Boxes too large for the cells of a grid, against all others.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/soa_boxes.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Appends the overlapping pairs of which at least one is in the slots [begin, end) and none behind
// them; returns the AABB checks. Cost: (end − begin) · end.
uint64_t FindPairsOfLast(const BoxLanes& lanes, size_t begin, size_t end, PairBuffer& out);

}  // namespace sweepstake
