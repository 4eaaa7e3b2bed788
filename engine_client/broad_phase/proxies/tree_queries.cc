// Queries in one tree: boxes that overlap a box, boxes near a point, boxes that a ray or a moving
// box hits, and the nearest such hit.
#include "engine_client/broad_phase/proxies/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/proxies/tree_queries.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/proxies/tree_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Passes the ids of the boxes found to the sink.
HWY_INLINE void TakeIds(const LeafTree::View& tree, const FoundGroup& found, const IdSink& sink) {
  uint32_t ids[LeafTree::kWidth];
  for (size_t k = 0; k < found.count; ++k) ids[k] = tree.levels[0].id[found.entry[k]];
  sink.take(sink.context, ids, found.count);
}

void WalkOverlapping(const LeafTree::View& tree, const Aabb& box, const IdSink& sink) {
  Descend(
      tree, 0,
      [&](size_t level, size_t base, FoundGroup& found)
          HWY_ATTR { CollectOverlapping(box, tree.levels[level], base, found); },
      [&](const FoundGroup& found) { TakeIds(tree, found, sink); });
}

// Computes SquaredDistance (query_shapes.h) for the lanes from slot `at` on. The result for a
// sentinel is +inf.
template <class D>
HWY_INLINE hn::Vec<D> SquaredDistanceLanes(D d, const float center[3], const BoxLanes& lanes,
                                           size_t at) {
  auto sum = hn::Zero(d);
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto point = hn::Set(d, center[axis]);
    const auto below = hn::Sub(hn::LoadU(d, lanes.min[axis] + at), point);
    const auto above = hn::Sub(point, hn::LoadU(d, lanes.max[axis] + at));
    const auto outside = hn::Max(hn::Zero(d), hn::Max(below, above));
    sum = hn::Add(sum, hn::Mul(outside, outside));
  }
  return sum;
}

void WalkNear(const LeafTree::View& tree, const float* center, float squared_radius,
              const IdSink& sink) {
  Descend(
      tree, 0,
      [&](size_t level, size_t base, FoundGroup& found) HWY_ATTR {
        const Lanes16 d;
        found.count = 0;
        for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
          const auto distance = SquaredDistanceLanes(d, center, tree.levels[level], at);
          AppendHits(d, hn::Le(distance, hn::Set(d, squared_radius)), at, found);
        }
      },
      [&](const FoundGroup& found) { TakeIds(tree, found, sink); });
}

// Computes EnterDistance (query_shapes.h) for the lanes from slot `at` on: returns the distances,
// and sets in `hits` the lanes whose box is entered at a distance of at most `limit`. The distances
// of other lanes mean nothing. A sentinel (min = +inf, max = −inf) is never a hit.
template <class D>
HWY_INLINE hn::Vec<D> EnterLanes(D d, const Slabs& slabs, float limit, const BoxLanes& lanes,
                                 size_t at, hn::Mask<D>& hits) {
  auto enter = hn::Zero(d);
  auto leave = hn::Set(d, limit);
  hits = hn::FirstN(d, hn::Lanes(d));
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto direction = hn::Set(d, slabs.direction[axis]);
    const auto to_min = hn::Sub(hn::LoadU(d, lanes.min[axis] + at), hn::Set(d, slabs.max[axis]));
    const auto to_max = hn::Sub(hn::LoadU(d, lanes.max[axis] + at), hn::Set(d, slabs.min[axis]));
    if (slabs.direction[axis] == 0) {
      const auto zero = hn::Zero(d);
      hits = hn::And(hits, hn::And(hn::Le(to_min, zero), hn::Ge(to_max, zero)));
    } else if (slabs.direction[axis] > 0) {
      enter = hn::Max(enter, hn::Div(to_min, direction));
      leave = hn::Min(leave, hn::Div(to_max, direction));
    } else {
      enter = hn::Max(enter, hn::Div(to_max, direction));
      leave = hn::Min(leave, hn::Div(to_min, direction));
    }
  }
  hits = hn::And(hits, hn::Le(enter, leave));
  return enter;
}

void WalkHits(const LeafTree::View& tree, const Slabs& slabs, const IdSink& sink) {
  Descend(
      tree, 0,
      [&](size_t level, size_t base, FoundGroup& found) HWY_ATTR {
        const Lanes16 d;
        found.count = 0;
        for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
          hn::Mask<Lanes16> hits;
          EnterLanes(d, slabs, slabs.max_distance, tree.levels[level], at, hits);
          AppendHits(d, hits, at, found);
        }
      },
      [&](const FoundGroup& found) { TakeIds(tree, found, sink); });
}

// The entries of a level that the ray hits, and the distances at which it enters them.
struct EnteredGroup {
  FoundGroup found;
  float distance[2 * LeafTree::kWidth];
};

HWY_INLINE void CollectEntered(const Slabs& slabs, float limit, const BoxLanes& lanes, size_t base,
                               EnteredGroup& group) {
  const Lanes16 d;
  group.found.count = 0;
  for (size_t at = base; at < base + LeafTree::kWidth; at += hn::Lanes(d)) {
    hn::Mask<Lanes16> hits;
    const auto enter = EnterLanes(d, slabs, limit, lanes, at, hits);
    hn::StoreU(CompressLanes(enter, hits), d, group.distance + group.found.count);
    AppendHits(d, hits, at, group.found);
  }
}

// Sorts by descending distance, since entries are taken from the end. Equal distances keep their
// order.
HWY_INLINE void SortFarthestFirst(EnteredGroup& group) {
  for (size_t k = 1; k < group.found.count; ++k) {
    const float distance = group.distance[k];
    const uint32_t entry = group.found.entry[k];
    size_t at = k;
    for (; at > 0 && group.distance[at - 1] < distance; --at) {
      group.distance[at] = group.distance[at - 1];
      group.found.entry[at] = group.found.entry[at - 1];
    }
    group.distance[at] = distance;
    group.found.entry[at] = entry;
  }
}

// Replaces `best` by the nearest accepted box of the group if that is nearer.
HWY_INLINE void TakeNearer(const EnteredGroup& group, const uint32_t* ids,
                           const IdPredicate& predicate, NearestHit& best, bool& found) {
  for (size_t k = 0; k < group.found.count; ++k) {
    const NearestHit hit{group.distance[k], ids[group.found.entry[k]]};
    const bool nearer = hit.distance < best.distance ||
                        (hit.distance == best.distance &&
                         (!found || predicate.is_before(predicate.context, hit.id, best.id)));
    if (!nearer || !predicate.accepts(predicate.context, hit.id)) continue;
    best = hit;
    found = true;
  }
}

bool WalkNearest(const LeafTree::View& tree, const Slabs& slabs, const IdPredicate& predicate,
                 NearestHit& hit) {
  EnteredGroup waiting[LeafTree::kMaxLevels + 1];
  NearestHit best{slabs.max_distance, 0};
  bool found = false;
  size_t level = tree.top;
  CollectEntered(slabs, best.distance, tree.levels[level], 0, waiting[level]);
  SortFarthestFirst(waiting[level]);
  while (true) {
    while (waiting[level].found.count == 0) {
      if (level == tree.top) {
        if (found) hit = best;
        return found;
      }
      ++level;
    }
    const size_t last = --waiting[level].found.count;
    if (waiting[level].distance[last] > best.distance) {
      waiting[level].found.count = 0;  // the remaining nodes are farther away
      continue;
    }
    const size_t node = waiting[level].found.entry[last];
    --level;
    CollectEntered(slabs, best.distance, tree.levels[level], FirstChild(level, node),
                   waiting[level]);
    if (level > 0) {
      SortFarthestFirst(waiting[level]);
    } else {
      TakeNearer(waiting[0], tree.levels[0].id, predicate, best, found);
      waiting[0].found.count = 0;
    }
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(WalkOverlapping);
HWY_EXPORT(WalkNear);
HWY_EXPORT(WalkHits);
HWY_EXPORT(WalkNearest);

void FindOverlapping(const LeafTree::View& tree, const Aabb& box, const IdSink& sink) {
  if (IsValid(box)) HWY_DYNAMIC_DISPATCH(WalkOverlapping)(tree, box, sink);
}

void FindNear(const LeafTree::View& tree, const float center[3], float squared_radius,
              const IdSink& sink) {
  HWY_DYNAMIC_DISPATCH(WalkNear)(tree, center, squared_radius, sink);
}

void FindHits(const LeafTree::View& tree, const Slabs& slabs, const IdSink& sink) {
  HWY_DYNAMIC_DISPATCH(WalkHits)(tree, slabs, sink);
}

bool FindNearestHit(const LeafTree::View& tree, const Slabs& slabs, const IdPredicate& predicate,
                    NearestHit& hit) {
  return tree.top != 0 && HWY_DYNAMIC_DISPATCH(WalkNearest)(tree, slabs, predicate, hit);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
