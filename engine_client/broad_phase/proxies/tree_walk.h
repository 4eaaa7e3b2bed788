// Walks over the tree of a BoxTree, on Highway: boxes that overlap a box, boxes that a ray hits,
// and pairs of the boxes of two trees.
//
// Thread safety: nothing is kept; any number of walks side by side. Ownership: views are borrowed.
// Order of what is found: depth first, the same on every target. No allocation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "sweepstake/aabb.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// Level 0 are the boxes, with ids; node k of a level above it bounds the entries [16 k, 16 k + 16)
// of the one below. The level `top` has at most 16 nodes. Empty: top is 0.
struct TreeView {
  std::array<BoxLanes, LeafTree::kMaxLevels + 1> levels{};
  size_t top = 0;
};

// take(context, ids, count) for what is found, at most 16 at a time.
struct IdSink {
  void (*take)(void* context, const uint32_t* ids, size_t count);
  void* context;
};

void FindOverlapping(const TreeView& tree, const Aabb& box, const IdSink& sink);
// REQUIRES: IsFinite(ray). As all walks with rays: by EnterDistance (ray_slabs.h).
void FindHits(const TreeView& tree, const Ray& ray, const IdSink& sink);

// The first box on a ray among those that are accepted.
struct NearestHit {
  float distance;
  uint32_t id;
};
struct IdPredicate {
  bool (*accepts)(void* context, uint32_t id);
  void* context;
};
// The accepted box with the least distance, equal ones by the least id; nothing changes where there
// is none up to ray.max_distance, else `hit` is filled and true returned.
bool FindNearestHit(const TreeView& tree, const Ray& ray, const IdPredicate& predicate,
                    NearestHit& hit);

// Appends {id of `leaves`, other_bit | id of `tree`} for the boxes of the leaves [begin, end) of
// `leaves` that overlap boxes of `tree`. Returns the AABB checks. Keeps its lists on the stack (50
// KiB). REQUIRES: begin is a multiple of 16; other_bit is above all ids.
uint64_t FindPairsBetween(const TreeView& leaves, size_t begin, size_t end, const TreeView& tree,
                          uint32_t other_bit, PairBuffer& out);

}  // namespace sweepstake
