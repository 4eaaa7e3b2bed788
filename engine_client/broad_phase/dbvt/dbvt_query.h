// Searches in a DbvtTree: vector kernels, dispatched at run time once per call.
//
// Stateless; threads may search at the same time with separate outputs. The functions append pairs
// of objects, a < b, in an order that depends on the tree alone. They return the number of AABB
// checks; every lane of a comparison counts as one check. They poll `stop`, which may be null,
// between leaves or objects.
#pragma once

#include <cstdint>
#include <span>

#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Finds the pairs of the objects below the lowest inner nodes `groups`: pairs with one another, and
// pairs with objects that follow in depth-first order. A call for all of tree.Groups() finds every
// overlapping pair once.
uint64_t FindGroupPairs(const DbvtTree& tree, std::span<const uint32_t> groups, PairBuffer& out,
                        StopRequest* stop);

// Finds the pairs of each listed object, whose box is fat[object], with all objects in the tree. A
// pair of two listed objects is found once. `is_listed` holds 1 for listed objects and 0 for
// others.
uint64_t FindPairsOf(const DbvtTree& tree, std::span<const uint32_t> objects, const Aabb* fat,
                     const uint8_t* is_listed, PairBuffer& out, StopRequest* stop);

}  // namespace sweepstake
