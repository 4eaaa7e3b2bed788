// A game that compiles Box2D with Sweepstake as its broad phase: the class that replaces Box2D's
// own, and the calls that Box2D makes to it.
#include "sweepstake/box2d.h"

#include "sweepstake/adaptive_broad_phase.h"

namespace {

sweepstake::AdaptiveBroadPhase& GameSearch() {
  static const auto search = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  return **search;
}

}  // namespace

class b2BroadPhase : public sweepstake::Box2dBroadPhase {
 public:
  b2BroadPhase() : Box2dBroadPhase(GameSearch()) {}
};

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
