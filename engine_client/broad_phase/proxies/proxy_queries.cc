#include "engine_client/broad_phase/proxies/proxy_queries.h"

#include <algorithm>
#include <cassert>

#include "engine_client/broad_phase/proxies/tree_walk.h"

namespace sweepstake {
namespace {

// The contexts of the searches' callbacks. The callbacks receive the rows of the boxes found.
struct VolumeQuery {
  const ProxyKind& kind;
  const CollisionFilter& filter;
  Found<ProxyHandle>& found;

  static void Take(void* context, const uint32_t* rows, size_t count) {
    const auto& query = *static_cast<const VolumeQuery*>(context);
    for (size_t k = 0; k < count; ++k) {
      if (!Passes(query.kind.table().filters()[rows[k]], query.filter)) continue;
      query.found.Add(query.kind.table().handle(rows[k]));
    }
  }
};

struct RayQuery {
  const ProxyKind& kind;
  const CollisionFilter& filter;
  const Slabs& slabs;
  Found<RayHit>* hits;

  static bool Accepts(void* context, uint32_t row) {
    const auto& query = *static_cast<const RayQuery*>(context);
    return Passes(query.kind.table().filters()[row], query.filter);
  }
  static bool IsBefore(void* context, uint32_t row, uint32_t other) {
    const ProxyTable& table = static_cast<const RayQuery*>(context)->kind.table();
    return table.handle(row) < table.handle(other);
  }
  static void Take(void* context, const uint32_t* rows, size_t count) {
    const auto& query = *static_cast<const RayQuery*>(context);
    for (size_t k = 0; k < count; ++k) {
      if (!Accepts(context, rows[k])) continue;
      const auto distance = EnterDistance(query.slabs, query.kind.table().boxes()[rows[k]]);
      assert(distance.has_value());
      query.hits->Add({query.kind.table().handle(rows[k]), distance.value_or(0)});
    }
  }
};

// Calls search(kind, tree) for each population whose proxies may pass the filter.
template <typename Search>
void ForEachTree(const ProxyKind& moving, const ProxyKind& resting, const CollisionFilter& filter,
                 const Search& search) {
  for (const ProxyKind* const kind : {&moving, &resting}) {
    for (uint32_t population = 0; population < kPopulations; ++population) {
      if (kind->count(population) == 0 || !Passes(kind->all(population), filter)) continue;
      search(*kind, kind->tree(population).view());
    }
  }
}

bool IsBefore(const RayHit& a, const RayHit& b) {
  return a.distance < b.distance || (a.distance == b.distance && a.proxy < b.proxy);
}

}  // namespace

void ProxyQueries::FindInBox(const Aabb& box, const CollisionFilter& filter,
                             Found<ProxyHandle>& found) const {
  ForEachTree(moving_, resting_, filter, [&](const ProxyKind& kind, const LeafTree::View& tree) {
    VolumeQuery query{kind, filter, found};
    FindOverlapping(tree, box, {VolumeQuery::Take, &query});
  });
  const std::span<ProxyHandle> items = found.items();
  std::sort(items.begin(), items.end());
}

void ProxyQueries::FindInSphere(const Sphere& sphere, const CollisionFilter& filter,
                                Found<ProxyHandle>& found) const {
  ForEachTree(moving_, resting_, filter, [&](const ProxyKind& kind, const LeafTree::View& tree) {
    VolumeQuery query{kind, filter, found};
    FindNear(tree, sphere.center, sphere.radius * sphere.radius, {VolumeQuery::Take, &query});
  });
  const std::span<ProxyHandle> items = found.items();
  std::sort(items.begin(), items.end());
}

void ProxyQueries::FindHits(const Slabs& slabs, const CollisionFilter& filter,
                            Found<RayHit>& hits) const {
  ForEachTree(moving_, resting_, filter, [&](const ProxyKind& kind, const LeafTree::View& tree) {
    RayQuery query{kind, filter, slabs, &hits};
    sweepstake::FindHits(tree, slabs, {RayQuery::Take, &query});
  });
  const std::span<RayHit> items = hits.items();
  std::sort(items.begin(), items.end(), IsBefore);
}

RayHit ProxyQueries::FindNearestHit(const Slabs& slabs, const CollisionFilter& filter) const {
  RayHit nearest{{}, slabs.max_distance};
  Slabs shorter = slabs;
  ForEachTree(moving_, resting_, filter, [&](const ProxyKind& kind, const LeafTree::View& tree) {
    RayQuery query{kind, filter, slabs, nullptr};
    NearestHit hit{};
    if (!sweepstake::FindNearestHit(tree, shorter, {RayQuery::Accepts, RayQuery::IsBefore, &query},
                                    hit))
      return;
    const RayHit found{kind.table().handle(hit.id), hit.distance + 0.0F};  // −0 + 0 = +0
    if (!nearest.proxy.is_null() && !IsBefore(found, nearest)) return;
    nearest = found;
    shorter.max_distance = found.distance;
  });
  return nearest.proxy.is_null() ? RayHit{} : nearest;
}

}  // namespace sweepstake
