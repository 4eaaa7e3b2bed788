// What a DbvtTree does to whole nodes: vector kernels chosen at run time once per call.
//
// Stateless; calls on distinct groups may run on distinct threads.
#pragma once

#include <cstdint>

#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// The box around all lanes. REQUIRES: the node has an entry.
Aabb NodeBounds(const DbvtNode& node);

// The children of this inner node that outgrew their reach, by lane; the others' reach shrinks with
// them.
uint16_t StretchedLanes(DbvtNode& node);

// Gives the objects in the leaves below `group`, a lowest inner node, their boxes, and the group's
// lanes the leaves' bounds. Motion is sampled at the first object of each leaf.
DbvtGroupNote RefitGroup(DbvtNode* nodes, const DbvtLink* links, uint32_t group, const Aabb* boxes,
                         float step);

// The node of `level` under which `box` makes the tree grow least; the boxes on the way there grow
// by it. REQUIRES: no node on the way is empty.
uint32_t DescendWidening(DbvtNode* nodes, const DbvtLink* links, uint32_t root, uint32_t level,
                         const Aabb& box);

}  // namespace sweepstake
