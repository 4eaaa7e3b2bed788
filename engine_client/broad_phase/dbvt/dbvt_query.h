// Searches in a DbvtTree: vector kernels chosen at run time once per call.
//
// Stateless; distinct outputs may be used by distinct threads. All append pairs of objects, a < b,
// in an order that depends on the tree alone, and return the AABB checks made: every lane of a
// comparison is one.
#pragma once

#include <cstdint>
#include <span>

#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// The overlapping pairs of the leaves below these lowest inner nodes with themselves and all that
// follow them in depth-first order. Over all of tree.Groups(): every overlapping pair once.
uint64_t FindGroupPairs(const DbvtTree& tree, std::span<const uint32_t> groups, PairBuffer& out);

// The pairs of each listed object, whose box is fat[object], with the objects in the tree; of two
// listed ones once. `is_listed` holds 1 for these objects and 0 for the others.
uint64_t FindPairsOf(const DbvtTree& tree, std::span<const uint32_t> objects, const Aabb* fat,
                     const uint8_t* is_listed, PairBuffer& out);

}  // namespace sweepstake
