#include "sweepstake/bullet.h"

#include <cstdint>
#include <utility>

namespace sweepstake {
namespace {

constexpr CollisionFilter kEverything{.category = ~0U, .mask = ~0U};

Aabb BoxOf(const btVector3& min, const btVector3& max) {
  return {{min.x(), min.y(), min.z()}, {max.x(), max.y(), max.z()}};
}

// Two such proxies cannot pass each other's filters.
bool IsStatic(int group, int mask) {
  return group == btBroadphaseProxy::StaticFilter && (mask & btBroadphaseProxy::StaticFilter) == 0;
}

// Returns the bounds of the box `min` to `max` on its way along the ray.
Aabb SweptBounds(const btVector3& from, const btVector3& to, const btVector3& min,
                 const btVector3& max) {
  btVector3 low = from;
  btVector3 high = from;
  low.setMin(to);
  high.setMax(to);
  return BoxOf(low + min, high + max);
}

}  // namespace

BulletBroadPhase::BulletBroadPhase(AdaptiveBroadPhase& search, Executor* executor)
    : search_(search), options_{.pair_events = true, .executor = executor}, proxies_(options_) {}

btBroadphaseProxy* BulletBroadPhase::createProxy(const btVector3& min, const btVector3& max,
                                                 int /*shape_type*/, void* client, int group,
                                                 int mask, btDispatcher* /*dispatcher*/) {
  Proxy& proxy = NewPlace();
  proxy.m_clientObject = client;
  proxy.m_collisionFilterGroup = group;
  proxy.m_collisionFilterMask = mask;
  proxy.m_aabbMin = min;
  proxy.m_aabbMax = max;
  proxy.filter = FilterOf(proxy);
  proxy.handle = proxies_.Add(BoxOf(min, max), {.filter = proxy.filter,
                                                .is_static = IsStatic(group, mask),
                                                .user = reinterpret_cast<uintptr_t>(&proxy)});
  return &proxy;
}

// The id of a proxy, by which the pair cache knows it, is that of its place, and the same for the
// same history of calls.
BulletBroadPhase::Proxy& BulletBroadPhase::NewPlace() {
  if (free_.empty()) {
    free_.reserve(places_.size() + 1);
    free_.push_back(&places_.emplace_back());
    free_.back()->m_uniqueId = static_cast<int>(places_.size());
  }
  Proxy& proxy = *free_.back();
  free_.pop_back();
  return proxy;
}

void BulletBroadPhase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  auto& own = static_cast<Proxy&>(*proxy);
  cache_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
  proxies_.Remove(std::exchange(own.handle, {}));
  free_.push_back(&own);
}

void BulletBroadPhase::setAabb(btBroadphaseProxy* proxy, const btVector3& min, const btVector3& max,
                               btDispatcher* /*dispatcher*/) {
  auto& own = static_cast<Proxy&>(*proxy);
  TakeFilter(own);
  // The world sends the boxes of all bodies in every step, those at rest included.
  const Aabb box = BoxOf(min, max);
  if (box == *proxies_.box(own.handle)) return;
  own.m_aabbMin = min;
  own.m_aabbMax = max;
  proxies_.Move(own.handle, box);
}

void BulletBroadPhase::getAabb(btBroadphaseProxy* proxy, btVector3& min, btVector3& max) const {
  min = proxy->m_aabbMin;
  max = proxy->m_aabbMax;
}

// The cache asks its callback, or looks at the groups, for each pair that it gets. What passes here
// is a superset: with a callback everything, and a proxy that nothing passes too, since queries
// must find it.
CollisionFilter BulletBroadPhase::FilterOf(const btBroadphaseProxy& proxy) const {
  const CollisionFilter filter{.category = static_cast<uint32_t>(proxy.m_collisionFilterGroup),
                               .mask = static_cast<uint32_t>(proxy.m_collisionFilterMask)};
  const bool passes_nothing = filter.category == 0 || filter.mask == 0;
  return callback_filters_ || passes_nothing ? kEverything : filter;
}

void BulletBroadPhase::TakeFilter(Proxy& proxy) {
  const CollisionFilter filter = FilterOf(proxy);
  if (filter == proxy.filter) return;
  proxy.filter = filter;
  proxies_.SetFilter(proxy.handle, filter);
}

void BulletBroadPhase::TakeFilterCallback() {
  const bool has_callback = cache_.getOverlapFilterCallback() != nullptr;
  if (std::exchange(callback_filters_, has_callback) == has_callback) return;
  for (Proxy& proxy : places_) {
    if (!proxy.handle.is_null()) TakeFilter(proxy);
  }
}

BulletBroadPhase::Proxy* BulletBroadPhase::Find(ProxyHandle handle) const {
  const auto options = proxies_.options(handle);
  // The user value holds the pointer itself.
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  return options ? reinterpret_cast<Proxy*>(static_cast<uintptr_t>(options->user)) : nullptr;
}

// The events ascend by handle, and so depend on no arm; the order of the cache follows from them.
void BulletBroadPhase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  TakeFilterCallback();
  proxies_.Resolve(search_.FindPairs(proxies_.moving_boxes()));
  for (const ProxyPair& pair : proxies_.removed()) {
    Proxy* const a = Find(pair.a);
    Proxy* const b = Find(pair.b);
    // The pairs of a proxy that was destroyed have left the cache with it.
    if (a != nullptr && b != nullptr) cache_.removeOverlappingPair(a, b, dispatcher);
  }
  for (const ProxyPair& pair : proxies_.added()) {
    cache_.addOverlappingPair(Find(pair.a), Find(pair.b));
  }
}

void BulletBroadPhase::rayTest(const btVector3& from, const btVector3& to,
                               btBroadphaseRayCallback& callback, const btVector3& min,
                               const btVector3& max) {
  if (!min.isZero() || !max.isZero()) {
    const Aabb bounds = SweptBounds(from, to, min, max);
    return aabbTest({bounds.min[0], bounds.min[1], bounds.min[2]},
                    {bounds.max[0], bounds.max[1], bounds.max[2]}, callback);
  }
  const btVector3 way = to - from;
  const Ray ray{{from.x(), from.y(), from.z()}, {way.x(), way.y(), way.z()}, /*max_distance=*/1};
  // The memory is taken, not shared: the callback may cast a ray itself.
  std::vector<RayHit> hits = std::move(hits_);
  if (!proxies_.CastRay(ray, kEverything, hits).ok()) hits.clear();
  for (const RayHit& hit : hits) {
    if (const Proxy* const proxy = Find(hit.proxy)) callback.process(proxy);
  }
  hits_ = std::move(hits);
}

void BulletBroadPhase::aabbTest(const btVector3& min, const btVector3& max,
                                btBroadphaseAabbCallback& callback) {
  std::vector<ProxyHandle> found = std::move(found_);
  proxies_.QueryBox(BoxOf(min, max), kEverything, found);
  for (const ProxyHandle handle : found) {
    if (const Proxy* const proxy = Find(handle)) callback.process(proxy);
  }
  found_ = std::move(found);
}

void BulletBroadPhase::getBroadphaseAabb(btVector3& min, btVector3& max) const {
  min.setZero();
  max.setZero();
  bool first = true;
  for (const Proxy& proxy : places_) {
    if (proxy.handle.is_null()) continue;
    if (std::exchange(first, false)) {
      min = proxy.m_aabbMin;
      max = proxy.m_aabbMax;
    }
    min.setMin(proxy.m_aabbMin);
    max.setMax(proxy.m_aabbMax);
  }
}

void BulletBroadPhase::resetPool(btDispatcher* /*dispatcher*/) {
  if (free_.size() < places_.size()) return;
  free_.clear();
  places_.clear();
  proxies_ = ProxySet(options_);
}

}  // namespace sweepstake
