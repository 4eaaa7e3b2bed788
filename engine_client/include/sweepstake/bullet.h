// Sweepstake as the broad phase of Bullet's worlds (Bullet 3.x, the classes bt…). The world calls
// it like any other; the game adds the frame:
//
//   auto search = AdaptiveBroadPhase::Create({}, sink);
//   BulletBroadPhase broad_phase(**search);
//   btDiscreteDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
//   ... each frame ...
//   (*search)->BeginFrame();
//   world.stepSimulation(dt_s, /*maxSubSteps=*/4);  // one search per substep
//   (*search)->EndFrame({.frame_time_ns = dt_ns});
//
// A search with a single arm is that broad phase without adaptation.
//
// What a switch of arms changes: nothing. The pairs of a step are exactly those whose boxes overlap
// (aabb.h); they enter and leave the pair cache in an order that depends on the calls of the game
// alone, whatever the arm and the number of threads. So the same calls give the same simulation bit
// for bit. Bullet's own broad phases also keep pairs whose boxes have come apart, or are merely
// near; Bullet makes islands of those too, so that their bodies fall asleep at other moments.
//
// Filters: a pair passes if each group is in the mask of the other, or, where the pair cache has an
// overlap filter callback, if that says so. It is asked when the boxes begin to overlap, and again
// when a group or a mask of the two changes or the cache gets another callback. Groups and masks
// that the game writes into a proxy count from its next setAabb on, with the same box too, which is
// the world's next step: a mask of 0 takes the pairs away, and the former one brings them back.
//
// What rests costs next to nothing. A proxy whose group is StaticFilter alone and whose mask lacks
// it, as the world gives to static and kinematic bodies, is static (proxy_set.h) while its box
// stays the same; another counts as sleeping when the world has sent the same box in thirty steps.
// It does so for bodies that are asleep, unless btCollisionWorld::setForceUpdateAllAabbs(false).
// Two static proxies do not meet, not even where a callback would let them.
//
// Thread safety: one thread at a time. Queries alone may be made by any number of threads at the
// same time between proxies().PrepareQueries() and the next change, which is what worlds with
// threads of their own need. Ownership: the search and the executor are borrowed and must outlive
// the broad phase, which must outlive the world. Units: those of the world. Cost: setAabb O(1), and
// nothing if the box is the same; calculateOverlappingPairs one search and O(pairs); destroyProxy
// O(pairs), since it clears its pairs at once; queries as in proxy_set.h, and memory is allocated
// for a query that finds more than 64. Memory: that of ProxySet, Bullet's pair cache, and 80 bytes
// per proxy. Errors: a box that is not valid overlaps nothing; std::bad_alloc. Bullet in double
// precision is refused when it is compiled.
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

static_assert(sizeof(btScalar) == sizeof(float),
              "the boxes of a world in double precision do not fit; build Bullet without "
              "BT_USE_DOUBLE_PRECISION");

class BulletBroadPhase final : public btBroadphaseInterface {
 public:
  // `executor` serves the search of moving bodies among static ones; the search of moving bodies
  // has its own (AdaptiveOptions).
  explicit BulletBroadPhase(AdaptiveBroadPhase& search, Executor* executor = nullptr);

  btBroadphaseProxy* createProxy(const btVector3& min, const btVector3& max, int shape_type,
                                 void* client, int group, int mask,
                                 btDispatcher* dispatcher) override;
  // The proxy's pairs leave the cache, and the ghost objects that it is in, at once.
  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  // Adds no pairs, and neither does createProxy: the next calculateOverlappingPairs does. Bullet's
  // btDbvtBroadphase adds them at once unless its m_deferedcollide is set. Code that moves an
  // object and reads its pairs within a step, as btKinematicCharacterController does, learns of a
  // new pair one search later, or calls calculateOverlappingPairs in between.
  void setAabb(btBroadphaseProxy* proxy, const btVector3& min, const btVector3& max,
               btDispatcher* dispatcher) override;
  void getAabb(btBroadphaseProxy* proxy, btVector3& min, btVector3& max) const override;

  // Passes every proxy that the ray hits, or the box `min` to `max` on its way along it, to the
  // callback by ascending distance. What the callback returns is ignored, as by Bullet's own broad
  // phases. The callback may query too, and add and remove proxies.
  void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
               const btVector3& min = {0, 0, 0}, const btVector3& max = {0, 0, 0}) override;
  // Passes every proxy that overlaps the box to the callback, as rayTest does.
  void aabbTest(const btVector3& min, const btVector3& max,
                btBroadphaseAabbCallback& callback) override;

  // Searches, and brings the pair cache up to date. REQUIRES: between BeginFrame and EndFrame of
  // the search.
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;

  btOverlappingPairCache* getOverlappingPairCache() override { return &cache_; }
  const btOverlappingPairCache* getOverlappingPairCache() const override { return &cache_; }
  // Returns the bounds of all boxes; zeros if there are no proxies. Cost: O(proxies).
  void getBroadphaseAabb(btVector3& min, btVector3& max) const override;
  // Forgets which places were used, so that a world that is filled anew gets the same ids as the
  // first time. Does nothing while there are proxies.
  void resetPool(btDispatcher* dispatcher) override;
  // Does nothing: the search's last_sample has the figures.
  void printStats() override {}

  // Returns the proxies, for their queries. The user value of each is its btBroadphaseProxy*.
  ProxySet& proxies() { return proxies_; }

 private:
  struct Proxy : btBroadphaseProxy {
    using btBroadphaseProxy::btBroadphaseProxy;
    ProxyHandle handle;
    CollisionFilter filter;      // the group and the mask that count
    uint32_t rest_count = 0;     // how often the same box has come, up to that at which it rests
    bool is_refiltered = false;  // the next search filters its pairs anew
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
  btOverlapFilterCallback* filter_callback_ = nullptr;  // the one that counts
  bool is_refiltered_ = false;                          // some proxy is
  std::deque<Proxy> places_;                            // free ones have a null handle
  std::vector<Proxy*> free_;
};

}  // namespace sweepstake
