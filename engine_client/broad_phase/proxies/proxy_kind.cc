#include "engine_client/broad_phase/proxies/proxy_kind.h"

#include <cassert>

#include "engine_client/broad_phase/proxies/ray_slabs.h"
#include "engine_client/broad_phase/proxies/tree_walk.h"

namespace sweepstake {
namespace {

// The searches call these structs with the places that they find.
struct BoxQuery {
  const ProxyKind& kind;
  const CollisionFilter& filter;
  std::vector<ProxyHandle>& out;

  static void Take(void* context, const uint32_t* places, size_t count) {
    const auto& query = *static_cast<const BoxQuery*>(context);
    for (size_t k = 0; k < count; ++k) {
      if (!Passes(query.kind.table().filters()[places[k]], query.filter)) continue;
      query.out.push_back(query.kind.HandleAt(places[k]));
    }
  }
};

struct RayQuery {
  const ProxyKind& kind;
  const CollisionFilter& filter;
  const Ray& ray;
  std::vector<RayHit>* hits;

  static bool Accepts(void* context, uint32_t place) {
    const auto& query = *static_cast<const RayQuery*>(context);
    return Passes(query.kind.table().filters()[place], query.filter);
  }
  static void Take(void* context, const uint32_t* places, size_t count) {
    const auto& query = *static_cast<const RayQuery*>(context);
    for (size_t k = 0; k < count; ++k) {
      if (!Accepts(context, places[k])) continue;
      const auto distance = EnterDistance(query.ray, query.kind.table().boxes()[places[k]]);
      assert(distance.has_value());
      query.hits->push_back({query.kind.HandleAt(places[k]), distance.value_or(0)});
    }
  }
};

}  // namespace

void ProxyKind::RefreshTree() {
  if (!table_.changed()) return;
  tree_.Update(table_.boxes());
  ++refit_count_;
  table_.MarkUnchanged();
}

void ProxyKind::QueryBox(const Aabb& box, const CollisionFilter& filter,
                         std::vector<ProxyHandle>& out) const {
  BoxQuery query{*this, filter, out};
  FindOverlapping(view(), box, {BoxQuery::Take, &query});
}

void ProxyKind::CastRay(const Ray& ray, const CollisionFilter& filter,
                        std::vector<RayHit>& hits) const {
  RayQuery query{*this, filter, ray, &hits};
  FindHits(view(), ray, {RayQuery::Take, &query});
}

RayHit ProxyKind::CastRayNearest(const Ray& ray, const CollisionFilter& filter) const {
  RayQuery query{*this, filter, ray, nullptr};
  NearestHit hit{};
  if (!FindNearestHit(view(), ray, {RayQuery::Accepts, &query}, hit)) return {};
  return {HandleAt(hit.id), hit.distance + 0.0F};  // −0 + 0 = +0
}

}  // namespace sweepstake
