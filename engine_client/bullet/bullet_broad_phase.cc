#include "sweepstake/bullet.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake {
namespace {

// A proxy rests (sleeps or becomes static) after Bullet has set the same box for it this number of
// times in a row. Falling asleep and waking each cost a search among all resting proxies. The
// number is therefore high enough for bodies that move every few steps not to fall asleep. Active
// bodies seldom do, since the last bits of their boxes change.
constexpr uint32_t kRestCount = 30;

constexpr CollisionFilter kEverything{.category = ~0U, .mask = ~0U};

Aabb BoxOf(const btVector3& min, const btVector3& max) {
  return {{min.x(), min.y(), min.z()}, {max.x(), max.y(), max.z()}};
}

ProxyHandle HandleOf(ProxyHandle handle) { return handle; }
ProxyHandle HandleOf(const RayHit& hit) { return hit.proxy; }

CollisionFilter WrittenFilterOf(const btBroadphaseProxy& proxy) {
  return {.category = static_cast<uint32_t>(proxy.m_collisionFilterGroup),
          .mask = static_cast<uint32_t>(proxy.m_collisionFilterMask)};
}

// Returns whether a proxy with this filter can be static: two such proxies never form a pair.
bool IsStatic(const CollisionFilter& filter) {
  constexpr uint32_t kStatic = btBroadphaseProxy::StaticFilter;
  return filter.category == kStatic && (filter.mask & kStatic) == 0;
}

}  // namespace

BulletBroadPhase::BulletBroadPhase(AdaptiveBroadPhase& search, Executor* executor)
    : search_(search), options_{.pair_events = true, .executor = executor}, proxies_(options_) {}

btBroadphaseProxy* BulletBroadPhase::createProxy(const btVector3& min, const btVector3& max,
                                                 int /*shape_type*/, void* client, int group,
                                                 int mask, btDispatcher* /*dispatcher*/) {
  Proxy& proxy = FreePlace();
  proxy.m_clientObject = client;
  proxy.m_collisionFilterGroup = group;
  proxy.m_collisionFilterMask = mask;
  proxy.m_aabbMin = min;
  proxy.m_aabbMax = max;
  proxy.filter = WrittenFilterOf(proxy);
  proxy.rest_count = IsStatic(proxy.filter) ? kRestCount : 0;
  proxy.is_refiltered = false;
  proxy.handle = proxies_.Add(BoxOf(min, max), {.filter = WideFilter(proxy.filter),
                                                .is_static = IsStatic(proxy.filter),
                                                .user = reinterpret_cast<uintptr_t>(&proxy)});
  free_.pop_back();  // last, since Add may run out of memory
  return &proxy;
}

// Returns a place for a new proxy. Each place has a fixed id, by which the pair cache identifies
// the proxy. The same sequence of calls thus always gives the same ids.
BulletBroadPhase::Proxy& BulletBroadPhase::FreePlace() {
  if (free_.empty()) {
    free_.reserve(places_.size() + 1);
    free_.push_back(&places_.emplace_back());
    free_.back()->m_uniqueId = static_cast<int>(places_.size());
  }
  return *free_.back();
}

void BulletBroadPhase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  auto& own = static_cast<Proxy&>(*proxy);
  cache_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
  proxies_.Remove(std::exchange(own.handle, {}));
  free_.push_back(&own);
}

void BulletBroadPhase::setAabb(btBroadphaseProxy* proxy, const btVector3& min, const btVector3& max,
                               btDispatcher* /*dispatcher*/) {
  const FloatEnvironmentScope environment;
  auto& own = static_cast<Proxy&>(*proxy);
  TakeFilter(own);
  const Aabb box = BoxOf(min, max);
  if (box == *proxies_.box(own.handle)) return Rest(own);
  own.m_aabbMin = min;
  own.m_aabbMax = max;
  Move(own, box);
}

// Sets the proxy's box. A static proxy that moves, such as the proxy of a kinematic body, becomes a
// moving one. Otherwise the tree of all static proxies would have to be refitted in each step.
void BulletBroadPhase::Move(Proxy& proxy, const Aabb& box) {
  proxies_.Move(proxy.handle, box);  // also wakes it
  if (std::exchange(proxy.rest_count, 0) == kRestCount) proxies_.SetStatic(proxy.handle, false);
}

void BulletBroadPhase::Rest(Proxy& proxy) {
  if (proxy.rest_count == kRestCount || ++proxy.rest_count < kRestCount) return;
  if (IsStatic(proxy.filter)) {
    proxies_.SetStatic(proxy.handle, true);
  } else {
    proxies_.SetSleeping(proxy.handle, true);
  }
}

void BulletBroadPhase::getAabb(btBroadphaseProxy* proxy, btVector3& min, btVector3& max) const {
  min = proxy->m_aabbMin;
  max = proxy->m_aabbMax;
}

// Returns the filter under which the proxy is added to ProxySet. It passes at least the pairs that
// Bullet's pair cache accepts: the cache applies its callback, or else the filter groups, to each
// pair again. With a callback it passes everything. A filter that passes nothing is widened too,
// since queries must find the proxy.
CollisionFilter BulletBroadPhase::WideFilter(const CollisionFilter& filter) const {
  const bool passes_nothing = filter.category == 0 || filter.mask == 0;
  return filter_callback_ != nullptr || passes_nothing ? kEverything : filter;
}

void BulletBroadPhase::TakeFilter(Proxy& proxy) {
  const CollisionFilter filter = WrittenFilterOf(proxy);
  if (filter == proxy.filter) return;
  proxies_.SetFilter(proxy.handle, WideFilter(filter));
  const bool is_static = IsStatic(filter);
  if (is_static != IsStatic(proxy.filter)) {
    proxies_.SetStatic(proxy.handle, is_static);
    proxy.rest_count = is_static ? kRestCount : 0;
  }
  proxy.filter = filter;
  proxy.is_refiltered = is_refiltered_ = true;
}

void BulletBroadPhase::TakeFilterCallback() {
  btOverlapFilterCallback* const callback = cache_.getOverlapFilterCallback();
  if (std::exchange(filter_callback_, callback) == callback) return;
  for (Proxy& proxy : places_) {
    if (proxy.handle.is_null()) continue;
    proxies_.SetFilter(proxy.handle, WideFilter(proxy.filter));
    proxy.is_refiltered = is_refiltered_ = true;
  }
}

BulletBroadPhase::Proxy* BulletBroadPhase::Find(ProxyHandle handle) const {
  const auto options = proxies_.options(handle);
  // The user value is the address of the Proxy (see createProxy).
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  return options ? reinterpret_cast<Proxy*>(static_cast<uintptr_t>(options->user)) : nullptr;
}

// ProxySet sorts the added and the removed pairs by handle, so that the order of pairs in the cache
// does not depend on the arm (the broad phase in use).
void BulletBroadPhase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  TakeFilterCallback();
  const auto pairs = search_.FindPairs(proxies_);
  if (search_.pairs_exceeded()) return;
  for (const ProxyPair& pair : proxies_.removed()) {
    Proxy* const a = Find(pair.a);
    Proxy* const b = Find(pair.b);
    // The pairs of a destroyed proxy have already left the cache.
    if (a != nullptr && b != nullptr) cache_.removeOverlappingPair(a, b, dispatcher);
  }
  for (const ProxyPair& pair : proxies_.added()) {
    cache_.addOverlappingPair(Find(pair.a), Find(pair.b));
  }
  if (std::exchange(is_refiltered_, false)) Refilter(pairs, dispatcher);
}

// Lets the cache decide again about all pairs of proxies whose filters have changed. The change
// causes no event if the boxes overlap before and after it and the wide filters pass both times. A
// pair that stays keeps its contacts. ProxySet has sorted `pairs`, like the events.
void BulletBroadPhase::Refilter(std::span<const OverlapPair> pairs, btDispatcher* dispatcher) {
  for (const auto& [first, second] : pairs) {
    Proxy* const a = Find(proxies_.handle(first));
    Proxy* const b = Find(proxies_.handle(second));
    if (!a->is_refiltered && !b->is_refiltered) continue;
    const bool passes = cache_.addOverlappingPair(a, b) != nullptr;
    if (!passes) cache_.removeOverlappingPair(a, b, dispatcher);
  }
  for (Proxy& proxy : places_) proxy.is_refiltered = false;
}

// Collects all results before the first call of the callback, since the callback may change the
// proxies. The callback runs in the game's floating-point environment.
template <typename Found, typename Query>
void BulletBroadPhase::PassFound(const Query& query, btBroadphaseAabbCallback& callback) {
  std::array<Found, 64> few;
  std::vector<Found> many;
  std::span<Found> found = few;
  size_t count = 0;
  {
    const FloatEnvironmentScope environment;
    Status status = query(found, count);
    if (status.code() == StatusCode::kFailedPrecondition) {  // the first query after a change
      proxies_.PrepareQueries();
      status = query(found, count);
    }
    if (status.ok() && count > found.size()) {
      many.resize(count);
      found = many;
      status = query(found, count);
    }
    if (!status.ok()) return;  // a query with infinite values finds nothing
  }
  for (const Found& one : found.first(count)) {
    if (const Proxy* const proxy = Find(HandleOf(one))) callback.process(proxy);
  }
}

void BulletBroadPhase::rayTest(const btVector3& from, const btVector3& to,
                               btBroadphaseRayCallback& callback, const btVector3& min,
                               const btVector3& max) {
  const ProxySet& proxies = proxies_;
  const auto query = [&](std::span<RayHit> hits, size_t& count) {
    const btVector3 way = to - from;
    if (min.isZero() && max.isZero()) {
      const Ray ray{
          {from.x(), from.y(), from.z()}, {way.x(), way.y(), way.z()}, /*max_distance=*/1};
      return proxies.CastRay(ray, kEverything, hits, count);
    }
    const BoxSweep box{BoxOf(from + min, from + max), {way.x(), way.y(), way.z()}};
    return proxies.SweepBox(box, kEverything, hits, count);
  };
  PassFound<RayHit>(query, callback);
}

void BulletBroadPhase::aabbTest(const btVector3& min, const btVector3& max,
                                btBroadphaseAabbCallback& callback) {
  const ProxySet& proxies = proxies_;
  const auto query = [&](std::span<ProxyHandle> found, size_t& count) {
    return proxies.QueryBox(BoxOf(min, max), kEverything, found, count);
  };
  PassFound<ProxyHandle>(query, callback);
}

void BulletBroadPhase::getBroadphaseAabb(btVector3& min, btVector3& max) const {
  const FloatEnvironmentScope environment;
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
