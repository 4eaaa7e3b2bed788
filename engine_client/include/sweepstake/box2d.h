// Sweepstake with the interface of b2BroadPhase, the broad phase of Box2D 2.4. Box2D has no virtual
// broad phase, so a built library cannot use this class. A game that compiles Box2D, as C++20,
// replaces box2d/b2_broad_phase.h by these lines, and leaves out b2_broad_phase.cpp:
//
//   #pragma once
//   #include "sweepstake/box2d.h"
//   sweepstake::AdaptiveBroadPhase& GameSearch();  // the game defines it, in any source
//   class b2BroadPhase : public sweepstake::Box2dBroadPhase {
//    public:
//     b2BroadPhase() : Box2dBroadPhase(GameSearch()) {}
//   };
//
// It marks the frames:
//
//   search.BeginFrame();
//   world.Step(step_s, velocity_iterations, position_iterations);
//   search.EndFrame({.frame_time_ns = dt_ns});
//
// A search serves one world. With a single arm it runs only that backend, without adaptation.
//
// Proxies get the same fat boxes as in Box2D: enlarged by b2_aabbExtension, and by the predicted
// movement. They are computed in the game's floating-point environment, as Box2D computes them, so
// that they are the same in each. UpdatePairs reports the same pairs: those whose fat boxes
// overlap, if one of the two was created, moved out of its fat box or touched since the previous
// UpdatePairs. Box2D thus makes the same contacts. The pairs are in ascending order of the ids,
// whatever the arm and the number of threads. Box2D's own order depends on its tree, so the solver
// may round differently.
//
// Thread safety: one thread at a time, also for queries. Ownership: the search and the executor are
// borrowed and must outlive the object. Units: the world's; z is 0. Memory: a ProxySet and 44 bytes
// per proxy. Errors: an invalid box overlaps nothing; after std::bad_alloc the object may only be
// destroyed.
//
// Cost: MoveProxy is O(1). UpdatePairs is one search and O(proxies not at rest). A proxy costs
// little once its fat box was the same for thirty searches (proxy_set.h). If less than one proxy in
// eight has changed, as for a time of impact, UpdatePairs makes a query for each instead. A frame
// without a search has detection time 0, and the decider learns nothing from it.
#pragma once

#include <box2d/b2_collision.h>

#include <cstdint>
#include <span>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// The functions are those of b2BroadPhase, which documents them.
class Box2dBroadPhase {
 public:
  enum { e_nullProxy = -1 };

  // `executor` runs the parts of the search among proxies at rest. The search among moving proxies
  // uses the executor of AdaptiveOptions.
  explicit Box2dBroadPhase(AdaptiveBroadPhase& search, Executor* executor = nullptr);

  int32 CreateProxy(const b2AABB& aabb, void* user_data);
  void DestroyProxy(int32 id);
  void MoveProxy(int32 id, const b2AABB& aabb, const b2Vec2& displacement);
  void TouchProxy(int32 id);

  const b2AABB& GetFatAABB(int32 id) const { return At(id).fat; }
  void* GetUserData(int32 id) const { return At(id).user_data; }
  bool TestOverlap(int32 a, int32 b) const { return b2TestOverlap(At(a).fat, At(b).fat); }
  int32 GetProxyCount() const { return static_cast<int32>(proxies_.moving_count()); }

  // If there are more pairs than AdaptiveOptions::max_pairs, proxies at rest included, reports no
  // pair, and the next call reports what is missing; pairs_exceeded() of the search is then true.
  // Box2D keeps its contacts meanwhile. REQUIRES: called between BeginFrame and EndFrame of the
  // search.
  template <typename T>
  void UpdatePairs(T* callback) {
    for (const auto& [a, b] : NewPairs()) {
      callback->AddPair(proxies_by_id_[a].user_data, proxies_by_id_[b].user_data);
    }
  }

  template <typename T>
  void Query(T* callback, const b2AABB& aabb) const {
    for (const ProxyHandle& proxy : InBox(aabb)) {
      if (!callback->QueryCallback(static_cast<int32>(proxy.index))) return;
    }
  }

  // Calls the callback by ascending distance of the fat boxes.
  template <typename T>
  void RayCast(T* callback, const b2RayCastInput& input) const {
    b2RayCastInput rest = input;
    for (const RayHit& hit : OnRay(input)) {
      if (hit.distance > rest.maxFraction) return;
      const float value = callback->RayCastCallback(rest, static_cast<int32>(hit.proxy.index));
      if (value == 0) return;
      if (value > 0) rest.maxFraction = value;
    }
  }

  // Always 0: only the tree of Box2D has these measures.
  int32 GetTreeHeight() const { return 0; }
  int32 GetTreeBalance() const { return 0; }
  float GetTreeQuality() const { return 0; }

  void ShiftOrigin(const b2Vec2& new_origin);

  // Returns the number of proxies that an UpdatePairs with a search visits: those not at rest.
  size_t awake_count() const { return awake_.size(); }
  // Returns the memory of the proxies in bytes, without that for one call.
  size_t native_bytes() const {
    return proxies_.native_bytes() + proxies_by_id_.capacity() * sizeof(Proxy) +
           awake_.capacity() * sizeof(int32);
  }

 private:
  static constexpr uint32_t kNotAwake = ~0U;

  struct Proxy {
    b2AABB fat = {};
    void* user_data = nullptr;
    ProxyHandle handle;             // null: this place is free
    uint32_t awake_at = kNotAwake;  // the index in awake_
    uint8_t rest_count = 0;         // searches without a change, up to a limit
    bool is_changed = false;        // created, moved or touched since the previous update
  };

  Proxy& At(int32 id) { return proxies_by_id_[static_cast<size_t>(id)]; }
  const Proxy& At(int32 id) const { return proxies_by_id_[static_cast<size_t>(id)]; }
  std::span<const OverlapPair> NewPairs();
  void Wake(int32 id);
  void Rest(int32 id);
  void Search();
  bool QueryChanged();
  std::vector<ProxyHandle> InBox(const b2AABB& aabb) const;
  std::vector<RayHit> OnRay(const b2RayCastInput& input) const;

  AdaptiveBroadPhase& search_;
  mutable ProxySet proxies_;  // the first query after a change updates its trees
  PairSorter sorter_;
  std::vector<Proxy> proxies_by_id_;
  std::vector<int32> awake_;         // the ids of the proxies not at rest, in any order
  std::vector<int32> changed_;       // the ids with is_changed
  uint32_t query_update_count_ = 0;  // updates without a search
  std::vector<OverlapPair> pairs_;
  std::vector<ProxyHandle> found_;
};

}  // namespace sweepstake
