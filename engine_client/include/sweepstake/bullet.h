// Sweepstake as the broad phase of Bullet's worlds (Bullet 3.x, the classes bt…). The world calls
// it like any other broad phase; the game marks the frames:
//
//   auto search = AdaptiveBroadPhase::Create({}, sink);
//   BulletBroadPhase broad_phase(**search);
//   btDiscreteDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
//   ... each frame ...
//   (*search)->BeginFrame();
//   world.stepSimulation(dt_s, /*maxSubSteps=*/4);  // one search per substep
//   (*search)->EndFrame({.frame_time_ns = dt_ns});
//
// A search with a single arm runs only that backend, without adaptation.
//
// A switch of arms does not change the simulation. The pairs of a step are exactly the pairs whose
// boxes overlap (aabb.h). They enter and leave the pair cache in an order that depends only on the
// game's calls, not on the arm or the number of threads. The same calls therefore give the same
// simulation bit for bit. Bullet's own broad phases also keep pairs whose boxes are merely near or
// no longer overlap. Bullet builds islands from those pairs too, so bodies fall asleep at other
// times than with Sweepstake.
//
// Filters: a pair passes if each group is in the mask of the other. If the pair cache has an
// overlap filter callback, its result counts instead. The callback is called when the boxes begin
// to overlap, and again when a group or mask of the pair or the callback itself changes. Groups and
// masks that the game writes into a proxy count from the proxy's next setAabb on, even with the
// same box; that is the world's next step. A mask of 0 removes the pairs, and restoring the mask
// brings them back.
//
// Objects at rest cost almost nothing. A proxy whose group is StaticFilter alone and whose mask
// lacks StaticFilter is static (proxy_set.h) while its box stays the same. The world gives this
// filter to static and kinematic bodies. Any other proxy counts as sleeping after thirty steps with
// the same box. The world sends the boxes of sleeping bodies too, unless
// btCollisionWorld::setForceUpdateAllAabbs(false) is set. Two static proxies never form a pair,
// even if a callback would accept it.
//
// Thread safety: one thread at a time. Any number of threads may query at the same time between
// proxies().PrepareQueries() and the next change; worlds with threads of their own need this.
// Ownership: the search and the executor are borrowed and must outlive the broad phase, which must
// outlive the world. Units: the world's. Memory: a ProxySet, Bullet's pair cache, and 80 bytes per
// proxy. Errors: an invalid box overlaps nothing; std::bad_alloc. Bullet in double precision fails
// to compile.
//
// Cost: setAabb is O(1), and free if the box is the same. calculateOverlappingPairs is one search
// and O(pairs). destroyProxy is O(pairs), because it removes its pairs at once. proxy_set.h states
// the cost of queries; a query that finds more than 64 proxies allocates.
#pragma once

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

static_assert(
    sizeof(btScalar) == sizeof(float),
    "boxes in double precision are not supported; build Bullet without BT_USE_DOUBLE_PRECISION");

class BulletBroadPhase final : public btBroadphaseInterface {
 public:
  // `executor` runs the parts of the search of moving bodies among static ones. The search among
  // moving bodies uses the executor of AdaptiveOptions.
  explicit BulletBroadPhase(AdaptiveBroadPhase& search, Executor* executor = nullptr);

  btBroadphaseProxy* createProxy(const btVector3& min, const btVector3& max, int shape_type,
                                 void* client, int group, int mask,
                                 btDispatcher* dispatcher) override;
  // Removes the proxy's pairs from the cache, and the proxy from its ghost objects, at once.
  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  // Adds no pairs, and neither does createProxy; the next calculateOverlappingPairs does. Bullet's
  // btDbvtBroadphase adds them at once unless its m_deferedcollide is set. Code that moves an
  // object and reads its pairs within a step, as btKinematicCharacterController does, sees a new
  // pair one search later. It can call calculateOverlappingPairs in between.
  void setAabb(btBroadphaseProxy* proxy, const btVector3& min, const btVector3& max,
               btDispatcher* dispatcher) override;
  void getAabb(btBroadphaseProxy* proxy, btVector3& min, btVector3& max) const override;

  // Passes to the callback, by ascending distance, every proxy that the ray hits, or that the box
  // `min` to `max` hits when swept along the ray. The callback's result is ignored, as in Bullet's
  // own broad phases. The callback may query, add and remove proxies.
  void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
               const btVector3& min = {0, 0, 0}, const btVector3& max = {0, 0, 0}) override;
  // Passes every proxy that overlaps the box to the callback, as rayTest does.
  void aabbTest(const btVector3& min, const btVector3& max,
                btBroadphaseAabbCallback& callback) override;

  // Searches and updates the pair cache. If there are more pairs than AdaptiveOptions::max_pairs,
  // proxies at rest included, the cache keeps its pairs until the next search, and the search's
  // pairs_exceeded() is true.
  // REQUIRES: called between BeginFrame and EndFrame of the search.
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;

  btOverlappingPairCache* getOverlappingPairCache() override { return &cache_; }
  const btOverlappingPairCache* getOverlappingPairCache() const override { return &cache_; }
  // Returns the bounds of all boxes; zeros if there are no proxies. Cost: O(proxies).
  void getBroadphaseAabb(btVector3& min, btVector3& max) const override;
  // Resets the ids, so that a world that is emptied and refilled gets the same ids as the first
  // time. Does nothing while any proxy exists.
  void resetPool(btDispatcher* dispatcher) override;
  // Does nothing: AdaptiveBroadPhase::last_sample() has the measurements.
  void printStats() override {}

  // Returns the proxies, for their queries. The user value of each is its btBroadphaseProxy*.
  ProxySet& proxies() { return proxies_; }

 private:
  struct Proxy : btBroadphaseProxy {
    using btBroadphaseProxy::btBroadphaseProxy;
    ProxyHandle handle;
    CollisionFilter filter;      // the group and the mask in effect
    uint32_t rest_count = 0;     // how often in a row the same box was sent, up to kRestCount
    bool is_refiltered = false;  // whether the next search must filter this proxy's pairs again
  };

  CollisionFilter WideFilter(const CollisionFilter& filter) const;
  void TakeFilter(Proxy& proxy);
  void TakeFilterCallback();
  void Refilter(std::span<const OverlapPair> pairs, btDispatcher* dispatcher);
  void Move(Proxy& proxy, const Aabb& box);
  void Rest(Proxy& proxy);
  Proxy& FreePlace();
  Proxy* Find(ProxyHandle handle) const;
  template <typename Found, typename Query>
  void PassFound(const Query& query, btBroadphaseAabbCallback& callback);

  AdaptiveBroadPhase& search_;
  const ProxySetOptions options_;
  ProxySet proxies_;
  btHashedOverlappingPairCache cache_;
  btOverlapFilterCallback* filter_callback_ = nullptr;  // the callback in effect
  bool is_refiltered_ = false;                          // whether any proxy has is_refiltered set
  std::deque<Proxy> places_;                            // free places have a null handle
  std::vector<Proxy*> free_;
};

}  // namespace sweepstake
