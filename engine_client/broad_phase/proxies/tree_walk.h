// Searches in the trees of ProxySet: the boxes that overlap a box, the boxes that a ray hits, and
// the pairs between two trees.
//
// Thread safety: stateless, so that any number of searches may run at the same time. Ownership:
// views are borrowed. Order of the results: depth first, the same on every target; the order of
// pairs depends on the target's register size. No allocation.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "engine_client/broad_phase/proxies/query_shapes.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Receives the ids that a search finds, at most 16 per call.
struct IdSink {
  void (*take)(void* context, const uint32_t* ids, size_t count);
  void* context;
};

void FindOverlapping(const LeafTree::View& tree, const Aabb& box, const IdSink& sink);
// Finds the boxes whose SquaredDistance (query_shapes.h) from the center is at most
// `squared_radius`. REQUIRES: all values are finite.
void FindNear(const LeafTree::View& tree, const float center[3], float squared_radius,
              const IdSink& sink);
// Finds the boxes that the slabs hit. FindHits and FindNearestHit use EnterDistance
// (query_shapes.h). REQUIRES: IsFinite(slabs).
void FindHits(const LeafTree::View& tree, const Slabs& slabs, const IdSink& sink);

struct NearestHit {
  float distance;
  uint32_t id;
};
struct IdPredicate {
  bool (*accepts)(void* context, uint32_t id);
  // Decides between two boxes that are equally near.
  bool (*is_before)(void* context, uint32_t id, uint32_t other_id);
  void* context;
};
// Finds the nearest accepted box; if several are equally near, the one before the others.
// Returns false and leaves `hit` unchanged if there is none up to max_distance.
bool FindNearestHit(const LeafTree::View& tree, const Slabs& slabs, const IdPredicate& predicate,
                    NearestHit& hit);

// Appends {id of `leaves`, other_bit | id of `tree`} for the boxes of the leaves [begin, end) of
// `leaves` that overlap boxes of `tree`. Returns the AABB checks. If the boxes are far apart, there
// are O(log boxes of `tree`) checks per box and 16 per leaf found. Keeps its lists on the stack (53
// KiB or less). `stop` may be null; after a stop, pairs are missing. REQUIRES: begin is a multiple
// of 16; other_bit is above all ids.
uint64_t FindPairsBetween(const LeafTree::View& leaves, size_t begin, size_t end,
                          const LeafTree::View& tree, uint32_t other_bit, PairBuffer& out,
                          StopRequest* stop = nullptr);

}  // namespace sweepstake
