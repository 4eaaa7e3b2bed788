// Vector kernels of DbvtTree that work on whole nodes, dispatched at run time once per call.
//
// Stateless; calls on distinct groups may run on distinct threads.
#pragma once

#include <cstdint>

#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// Returns the bounds of the boxes in all lanes. REQUIRES: the node has an entry.
Aabb NodeBounds(const DbvtNode& node);

// Returns, as bits, the lanes of this inner node whose children have grown beyond their reach, the
// size limit that dbvt_tree.h defines. Reduces the reach of children that have shrunk.
uint16_t StretchedLanes(DbvtNode& node);

// Copies the objects' new boxes to the leaves of a group (defined at DbvtGroupNote), and the bounds
// of these leaves to the group's inner node. Samples the motion of each leaf's first object.
DbvtGroupNote RefitGroup(DbvtNode* nodes, const DbvtLink* links, uint32_t group, const Aabb* boxes,
                         float step);

// Finds the node of `level` below which `box` enlarges the tree least, and widens the boxes on the
// way there to cover it. REQUIRES: no node on the way is empty.
uint32_t DescendWidening(DbvtNode* nodes, const DbvtLink* links, uint32_t root, uint32_t level,
                         const Aabb& box);

}  // namespace sweepstake
