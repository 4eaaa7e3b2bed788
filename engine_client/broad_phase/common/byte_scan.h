// Scans over the slots of ByteBoxes: every box against every later one, first by bytes, then
// exactly. What BruteForce, SAP and AxisSweep share.
//
// Cost: a row of 64 checks takes 3 cycles with AVX-512 (BruteForce), 2 in a sweep; what passes the
// bytes about 3 ns more. Throws std::bad_alloc.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/byte_boxes.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Slots that share a load of others: what [begin, end) below are multiples of.
inline constexpr size_t kRowsPerTile = 4;

// Appends each pair of a slot in [begin, end) and a later one that overlap; returns the AABB checks
// made.
uint64_t FindPairsOfAll(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out);
// The same for swept slots: none is compared that begins after all four of its tile have ended.
uint64_t FindPairsOfSwept(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out);

}  // namespace sweepstake
