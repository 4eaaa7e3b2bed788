// A game that compiles Box2D with Sweepstake as its broad phase. Box2D's headers contain the lines
// that sweepstake/box2d.h gives for b2_broad_phase.h (CMakeLists.txt). The calls are those of
// Box2D.
#include <box2d/box2d.h>

#include <type_traits>

#include "sweepstake/adaptive_broad_phase.h"

sweepstake::AdaptiveBroadPhase& GameSearch() {
  static const auto search = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  return **search;
}

namespace {

struct Counter {
  void AddPair(void* /*a*/, void* /*b*/) { ++pair_count; }
  bool QueryCallback(int32 /*id*/) { return ++found_count > 0; }
  float RayCastCallback(const b2RayCastInput& input, int32 /*id*/) {
    ++hit_count;
    return input.maxFraction;
  }

  int pair_count = 0;
  int found_count = 0;
  int hit_count = 0;
};

b2AABB BoxAt(float x) {
  b2AABB box;
  box.lowerBound.Set(x, 0);
  box.upperBound.Set(x + 1, 1);
  return box;
}

}  // namespace

int main() {
  static_assert(std::is_same_v<decltype(b2ContactManager::m_broadPhase), b2BroadPhase>);
  static_assert(std::is_base_of_v<sweepstake::Box2dBroadPhase, b2BroadPhase>);
  b2BroadPhase broad_phase;
  for (const float x : {0.0F, 0.5F, 5.0F}) broad_phase.CreateProxy(BoxAt(x), nullptr);
  Counter counter;
  GameSearch().BeginFrame();
  broad_phase.UpdatePairs(&counter);
  GameSearch().EndFrame({.frame_time_ns = 16'666'667});
  broad_phase.Query(&counter, BoxAt(0));
  b2RayCastInput ray;
  ray.p1.Set(-1, 0.5F);
  ray.p2.Set(9, 0.5F);
  ray.maxFraction = 1;
  broad_phase.RayCast(&counter, ray);
  return counter.pair_count == 1 && counter.found_count == 2 && counter.hit_count == 3 ? 0 : 1;
}
