// Scans over the slots of ByteBoxes, which BruteForce, SAP and AxisSweep share: every box is tested
// against every later one, first in bytes, then exactly.
//
// Cost: 64 checks in bytes take 3 cycles with AVX-512 (2 in a sweep), an exact test about 3 ns (AMD
// Zen 5, `sweepstake-lab bench --scene suite-b`). The same checks take 1.8 times as long with AVX2
// and 2.9 times with SSE4 (AMD Zen 4, SAP from 10,000 to 100,000 boxes). Throws std::bad_alloc.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/byte_boxes.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// The number of consecutive slots in a tile. A register of other slots is loaded once and compared
// with all slots of a tile. `begin` and `end` below are multiples of this number.
inline constexpr size_t kRowsPerTile = 4;

// The minimum number of slots per part of a sweep. A smaller part takes less time than waking a
// thread.
inline constexpr size_t kMinSweptPerPart = 1024;

// Appends each overlapping pair of a slot in [begin, end) and a later slot; returns the number of
// AABB checks. `expected_pairs`, the expected number of pairs of all slots, affects only the time.
// Polls `stop`, which may be null, between tiles.
uint64_t FindPairsOfAll(const ByteLanes& lanes, size_t begin, size_t end, size_t expected_pairs,
                        PairBuffer& out, StopRequest* stop);
// Appends each overlapping pair of a swept slot in [begin, end) and a later slot; returns the
// number of AABB checks. A tile is not compared with slots whose boxes begin, on the sweep axis,
// behind the end of all boxes of the tile. Polls `stop`, which may be null, between tiles.
uint64_t FindPairsOfSwept(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out,
                          StopRequest* stop);
// Returns the approximate time of one check of a sweep in ns, with the instruction set that runs.
// It includes the exact tests of candidates.
double SweptCheckNs();

}  // namespace sweepstake
