// Overlap queries on a DbvtTree: vector kernels chosen at run time once per call.
//
// Stateless; distinct outputs may be used by distinct threads. All append pairs of leaves, a < b,
// in an order that depends on the tree alone, and return the number of AABB checks made: one per
// node looked at or pair tested.
#pragma once

#include <cstdint>
#include <span>

#include "engine_client/broad_phase/dbvt_tree.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// A box in two half registers; the fourth lanes are not looked at.
struct alignas(32) PackedBox {
  float min[4];
  float max[4];
};

// The overlapping pairs of boxes in the tree of which at least one is in `leaves`, once.
// `is_listed` holds 1 for these leaves and 0 for the others.
uint64_t FindLeafPairsOf(const DbvtTree& tree, std::span<const uint32_t> leaves,
                         const uint8_t* is_listed, PairBuffer& out);

// Appends those candidates whose exact boxes overlap.
uint64_t KeepOverlapping(std::span<const OverlapPair> candidates, const PackedBox* boxes,
                         PairBuffer& out);

}  // namespace sweepstake
