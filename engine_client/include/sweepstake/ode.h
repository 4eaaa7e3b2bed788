// Sweepstake as the broad phase of a space of ODE (Open Dynamics Engine). The geoms stay in their
// dSpaceID; the game calls Collide where it called dSpaceCollide, and marks the frames:
//
//   auto search = AdaptiveBroadPhase::Create({}, sink);
//   OdeBroadPhase broad_phase(**search, space);  // any kind of space
//   ... each frame ...
//   (*search)->BeginFrame();
//   broad_phase.Collide(data, &NearCallback);    // again before each further step of the world
//   dWorldQuickStep(world, step_s);
//   dJointGroupEmpty(contacts);
//   (*search)->EndFrame({.frame_time_ns = dt_ns});
//
// A search with a single arm runs only that backend, without adaptation.
//
// Pairs: Collide makes the same calls as dSpaceCollide of a dSimpleSpace with the same list of
// geoms, in the same order. The contacts therefore do not depend on the arm or the number of
// threads. With a dSimpleSpace the simulation is the same bit for bit as with dSpaceCollide.
// dHashSpace of ODE 0.16.2 misses a few of the pairs, and dSweepAndPruneSpace adds pairs of planes
// whose boxes do not overlap. A dQuadTreeSpace has no list; its geoms count in the order in which
// it passes them to dSpaceCollide2. The rules are those of ODE:
// - The geoms are enabled and not of zero size.
// - They do not belong to the same body.
// - The category bits of one meet the collide bits of the other.
// - Their boxes overlap, compared in dReal. Infinite boxes, such as those of planes, are allowed.
// There is one exception. ODE also calls the function aabb_test of a class made by
// dCreateGeomClass, which its interface does not give access to, and Collide does not call it.
//
// A space in the space is one geom with one box, as in dSpaceCollide. The callback passes such a
// pair to dSpaceCollide2.
//
// If there are more pairs than AdaptiveOptions::max_pairs, geoms at rest included, Collide makes
// the calls of the previous pairs that still are pairs. The search's pairs_exceeded() is then true.
//
// A geom at rest costs little: after thirty searches with the same box it counts as sleeping
// (proxy_set.h).
//
// Thread safety: one thread at a time. Ownership: the search, the space and the executor are
// borrowed and must outlive the object. A search serves one OdeBroadPhase. Units: the world's.
// Memory: a ProxySet and about 120 bytes per geom. Errors: after std::bad_alloc the object may only
// be destroyed.
//
// Cost of Collide: one search, and O(geoms + pairs). It allocates only when the numbers of geoms or
// pairs reach a new maximum, or geoms are added.
#pragma once

#include <ode/collision.h>

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class OdeBroadPhase final {
 public:
  // `executor` runs the parts of the search among geoms at rest. The search among moving geoms uses
  // the executor of AdaptiveOptions.
  OdeBroadPhase(AdaptiveBroadPhase& search, dSpaceID space, Executor* executor = nullptr);

  // Searches, then calls the callback for each pair. REQUIRES: called between BeginFrame and
  // EndFrame of the search. As in dSpaceCollide, the callback must not move, add, remove or destroy
  // geoms of the space.
  void Collide(void* data, dNearCallback* callback);

  // Returns the number of places for geoms, one for each id up to the highest in use.
  size_t place_count() const { return geoms_.size(); }

 private:
  using Bounds = std::array<dReal, 6>;  // min and max of x, then of y, then of z

  struct Geom {
    dGeomID geom = nullptr;  // null: this place is free
    ProxyHandle proxy;
    Bounds bounds = {};
    uint32_t place = kNoPlace;  // in order_
    uint32_t rest_count = 0;    // how often in a row the box was the same, up to a limit
  };
  static constexpr uint32_t kNoPlace = ~0U;

  struct DestroyGeom {
    void operator()(dGeomID geom) const { dGeomDestroy(geom); }
  };

  void Search();
  void AddPair(uint32_t a, uint32_t b);
  void AddPreviousPairs(const std::vector<OverlapPair>& pairs);
  static bool IsPair(const Geom& a, const Geom& b);
  void ListGeoms();
  void ReadGeoms();
  uint32_t IdOf(dGeomID geom);
  void ReadBox(Geom& geom);
  void RemoveAbsent();

  AdaptiveBroadPhase& search_;
  const dSpaceID space_;
  std::unique_ptr<dxGeom, DestroyGeom> everywhere_;  // overlaps each geom of a quadtree
  ProxySet proxies_;
  PairSorter sorter_;
  std::vector<dGeomID> listed_;  // the geoms of the space
  std::vector<Geom> geoms_;      // by the id of the proxy
  std::unordered_map<dGeomID, uint32_t> ids_;
  std::vector<uint32_t> order_;       // the ids in the order of the space's list
  std::vector<uint32_t> last_order_;  // the same of the previous search
  std::vector<OverlapPair> pairs_;    // by place in order_
};

}  // namespace sweepstake
