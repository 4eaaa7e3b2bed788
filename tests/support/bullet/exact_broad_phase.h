// A broad phase of Bullet that shows the world only pairs whose boxes overlap.
//
// Bullet's broad phases also keep pairs whose boxes are only near, or separated some steps ago.
// Such pairs make no contacts, but they join islands, which fall asleep together. Here these pairs
// stay in the broad phase's own cache; the world uses a second cache.
#pragma once

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <LinearMath/btAabbUtil2.h>

#include <type_traits>
#include <vector>

namespace sweepstake::test_support {

template <typename Base>
class ExactBroadPhase final : public Base {
 public:
  using Base::Base;

  btBroadphaseProxy* createProxy(const btVector3& min, const btVector3& max, int shape_type,
                                 void* client, int group, int mask,
                                 btDispatcher* dispatcher) override {
    if constexpr (kIdsGrow) Base::m_gid = TakeId() - 1;
    btBroadphaseProxy* const proxy =
        Base::createProxy(min, max, shape_type, client, group, mask, dispatcher);
    proxy->m_aabbMin = min;  // btAxisSweep3 itself stores it only in setAabb
    proxy->m_aabbMax = max;
    return proxy;
  }

  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override {
    if constexpr (kIdsGrow) free_ids_.push_back(proxy->m_uniqueId);
    exact_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
    Base::destroyProxy(proxy, dispatcher);
  }

  void calculateOverlappingPairs(btDispatcher* dispatcher) override {
    Base::calculateOverlappingPairs(dispatcher);
    const btBroadphasePairArray& shown = exact_.getOverlappingPairArray();
    // Removing a pair moves the last one to its place.
    for (int i = shown.size(); i-- > 0;) {
      const btBroadphasePair pair = shown[i];
      if (!Overlap(pair)) exact_.removeOverlappingPair(pair.m_pProxy0, pair.m_pProxy1, dispatcher);
    }
    const btBroadphasePairArray& kept = Base::getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < kept.size(); ++i) {
      if (Overlap(kept[i])) exact_.addOverlappingPair(kept[i].m_pProxy0, kept[i].m_pProxy1);
    }
  }

  btOverlappingPairCache* getOverlappingPairCache() override { return &exact_; }
  const btOverlappingPairCache* getOverlappingPairCache() const override { return &exact_; }

 private:
  // btDbvtBroadphase never reuses ids. Bullet's other broad phases reuse the last freed id first.
  static constexpr bool kIdsGrow = std::is_same_v<Base, btDbvtBroadphase>;

  static bool Overlap(const btBroadphasePair& pair) {
    return TestAabbAgainstAabb2(pair.m_pProxy0->m_aabbMin, pair.m_pProxy0->m_aabbMax,
                                pair.m_pProxy1->m_aabbMin, pair.m_pProxy1->m_aabbMax);
  }

  int TakeId() {
    if (free_ids_.empty()) return ++id_count_;
    const int id = free_ids_.back();
    free_ids_.pop_back();
    return id;
  }

  btHashedOverlappingPairCache exact_;
  std::vector<int> free_ids_;
  int id_count_ = 0;
};

}  // namespace sweepstake::test_support
