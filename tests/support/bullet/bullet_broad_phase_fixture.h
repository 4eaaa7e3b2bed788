// Creates proxies of Sweepstake's broad phase for Bullet, without a world.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "sweepstake/bullet.h"
#include "tests/support/bullet/adaptive_bullet_game.h"

namespace sweepstake::test_support {

inline constexpr int kDefault = btBroadphaseProxy::DefaultFilter;
inline constexpr int kStatic = btBroadphaseProxy::StaticFilter;
inline constexpr int kAll = btBroadphaseProxy::AllFilter;

class BulletBroadPhaseTest : public ::testing::Test {
 protected:
  // Adds a cube of edge 1 whose lowest corner is (x, 0, 0).
  btBroadphaseProxy* Add(float x, int group = kDefault, int mask = kAll) {
    return broad_phase_.createProxy({x, 0, 0}, {x + 1, 1, 1}, BOX_SHAPE_PROXYTYPE, nullptr, group,
                                    mask, nullptr);
  }
  void Move(btBroadphaseProxy* proxy, float x) {
    broad_phase_.setAabb(proxy, {x, 0, 0}, {x + 1, 1, 1}, nullptr);
  }
  void Step() {
    search_->BeginFrame();
    broad_phase_.calculateOverlappingPairs(nullptr);
    search_->EndFrame({.frame_time_ns = 1});
  }
  int SleepingCount() {
    std::vector<ProxyHandle> all;
    broad_phase_.proxies().QueryBox({{-99, -99, -99}, {99, 99, 99}}, {~0U, ~0U}, all);
    return static_cast<int>(std::count_if(all.begin(), all.end(), [&](ProxyHandle handle) {
      return broad_phase_.proxies().is_sleeping(handle);
    }));
  }
  btOverlappingPairCache& cache() { return *broad_phase_.getOverlappingPairCache(); }
  bool AreKept(btBroadphaseProxy* a, btBroadphaseProxy* b) {
    return cache().findPair(a, b) != nullptr;
  }

  std::unique_ptr<AdaptiveBroadPhase> search_ =
      std::move(*AdaptiveBroadPhase::Create(OneArm("Grid", nullptr, kMaxPairs), nullptr));
  BulletBroadPhase broad_phase_{*search_};
};

}  // namespace sweepstake::test_support
