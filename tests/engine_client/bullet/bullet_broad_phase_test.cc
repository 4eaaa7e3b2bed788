#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "sweepstake/hooks.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bullet/adaptive_bullet_game.h"
#include "tests/support/bullet/bullet_broad_phase_fixture.h"
#include "tests/support/float_modes.h"

namespace sweepstake::test_support {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

using Proxies = std::vector<const btBroadphaseProxy*>;

// Collects the results of a ray or box query, and calls a function of the test during the query.
class Collector final : public btBroadphaseRayCallback {
 public:
  bool process(const btBroadphaseProxy* proxy) override {
    found.push_back(proxy);
    if (on_found) on_found();
    return false;  // The caller ignores the result.
  }

  Proxies found;
  std::function<void()> on_found;
};

TEST_F(BulletBroadPhaseTest, KeepsAPairWhileTheBoxesOverlap) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(5);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 0);
  Move(b, 1);  // faces that touch overlap
  Step();
  EXPECT_TRUE(AreKept(a, b));
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
  Move(b, 1.01F);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 0);
}

TEST_F(BulletBroadPhaseTest, DestroyingAProxyRemovesItsPairsAtOnce) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0.5F);
  btBroadphaseProxy* const c = Add(1);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 3);
  broad_phase_.destroyProxy(b, nullptr);
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
  EXPECT_TRUE(AreKept(a, c));
}

TEST_F(BulletBroadPhaseTest, AProxyInAReusedSlotHasItsOwnPairs) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0.5F);
  Step();
  broad_phase_.destroyProxy(b, nullptr);
  btBroadphaseProxy* const c = Add(0.75F);
  EXPECT_EQ(c, b);  // the same memory and the same id
  EXPECT_EQ(cache().getNumOverlappingPairs(), 0);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
  EXPECT_TRUE(AreKept(a, c));
}

TEST_F(BulletBroadPhaseTest, StaticProxiesFormPairsOnlyWithMovingOnes) {
  constexpr int kNotStatic = kAll ^ kStatic;
  btBroadphaseProxy* const floor = Add(0, kStatic, kNotStatic);
  btBroadphaseProxy* const wall = Add(0.5F, kStatic, kNotStatic);
  btBroadphaseProxy* const ball = Add(0.75F);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 2);
  Step();
  EXPECT_TRUE(AreKept(floor, ball) && AreKept(wall, ball));
  EXPECT_EQ(cache().getNumOverlappingPairs(), 2);
  Move(floor, -5);
  Step();
  EXPECT_FALSE(AreKept(floor, ball));
}

// With this mask, static proxies form pairs with each other. The static tree cannot find such
// pairs, so the proxies are searched like moving ones.
TEST_F(BulletBroadPhaseTest, AStaticGroupThatMatchesItselfIsSearchedLikeMovingOnes) {
  btBroadphaseProxy* const a = Add(0, kStatic, kAll);
  btBroadphaseProxy* const b = Add(0, kStatic, kAll);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 0);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletBroadPhaseTest, AnInvalidBoxHasNoPairsAndNoQueryFindsIt) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Move(b, nan);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  Collector query;
  broad_phase_.aabbTest({-9, -9, -9}, {9, 9, 9}, query);
  EXPECT_THAT(query.found, ElementsAre(a));
  Move(b, 0);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletBroadPhaseTest, AProxyUnchangedForThirtyStepsSleepsAndKeepsItsPairs) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0.5F);
  for (int step = 0; step < 30; ++step) {
    EXPECT_EQ(SleepingCount(), 0);
    Move(a, 0);
    Move(b, 0.5F);
    Step();
  }
  EXPECT_EQ(SleepingCount(), 2);
  EXPECT_TRUE(AreKept(a, b));
  Move(b, 0.75F);
  EXPECT_EQ(SleepingCount(), 1);
  Step();
  EXPECT_TRUE(AreKept(a, b));
  Move(b, 5);
  Step();
  EXPECT_FALSE(AreKept(a, b));
}

// A kinematic body, such as a lift, has the same filter as a static one.
TEST_F(BulletBroadPhaseTest, AStaticProxyThatMovesIsMovingUntilItRests) {
  constexpr int kNotStatic = kAll ^ kStatic;
  btBroadphaseProxy* const lift = Add(0, kStatic, kNotStatic);
  btBroadphaseProxy* const wall = Add(0, kStatic, kNotStatic);
  btBroadphaseProxy* const ball = Add(1);
  Step();
  Move(lift, 0.5F);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 1U);
  Step();
  EXPECT_FALSE(AreKept(lift, wall));
  EXPECT_TRUE(AreKept(lift, ball) && AreKept(wall, ball));
  for (int step = 0; step < 30; ++step) Move(lift, 0.5F);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 2U);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 2);
}

TEST_F(BulletBroadPhaseTest, AQueryWithManyResultsFindsAll) {
  for (int i = 0; i < 200; ++i) Add(static_cast<float>(i) * 0.01F);
  Collector query;
  broad_phase_.aabbTest({0, 0, 0}, {3, 1, 1}, query);
  EXPECT_EQ(query.found.size(), 200U);
  Collector ray;
  broad_phase_.rayTest({-1, 0.5F, 0.5F}, {4, 0.5F, 0.5F}, ray);
  EXPECT_EQ(ray.found.size(), 200U);
  EXPECT_EQ(ray.found.front()->m_uniqueId, 1);
}

TEST_F(BulletBroadPhaseTest, PreparedQueriesCanRunOnManyThreads) {
  for (int i = 0; i < 100; ++i) Add(static_cast<float>(i) * 0.01F, i % 2 == 0 ? kDefault : kStatic);
  broad_phase_.proxies().PrepareQueries();
  Collector collectors[4];
  std::vector<std::thread> threads;
  for (Collector& collector : collectors) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        broad_phase_.rayTest({-1, 0.5F, 0.5F}, {4, 0.5F, 0.5F}, collector);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Collector& collector : collectors) EXPECT_EQ(collector.found.size(), 2000U);
}

TEST_F(BulletBroadPhaseTest, AStepAllocatesNothingInSteadyState) {
  std::vector<btBroadphaseProxy*> proxies;
  for (int i = 0; i < 100; ++i) proxies.push_back(Add(static_cast<float>(i)));
  const auto play = [&] {
    for (int step = 0; step < 40; ++step) {
      for (int i = 0; i < 100; ++i) {
        Move(proxies[static_cast<size_t>(i)], static_cast<float>(i * (1 + step % 3)));
      }
      broad_phase_.destroyProxy(proxies.back(), nullptr);
      proxies.back() = Add(99);
      Step();
    }
  };
  play();
  const uint64_t before = ThreadAllocationCount();
  play();
  EXPECT_EQ(ThreadAllocationCount(), before);
}

TEST_F(BulletBroadPhaseTest, RaysFindTheNearestBoxFirst) {
  btBroadphaseProxy* const far = Add(8);
  btBroadphaseProxy* const near = Add(2, kStatic, kAll ^ kStatic);
  Add(12);
  Collector ray;
  broad_phase_.rayTest({0, 0.5F, 0.5F}, {10, 0.5F, 0.5F}, ray);
  EXPECT_THAT(ray.found, ElementsAre(near, far));
  Collector away;
  broad_phase_.rayTest({0, 3, 0.5F}, {10, 3, 0.5F}, away);
  EXPECT_THAT(away.found, IsEmpty());
}

TEST_F(BulletBroadPhaseTest, ASweptBoxFindsABoxThatItsCentreMisses) {
  btBroadphaseProxy* const a = Add(4);
  Collector sweep;
  broad_phase_.rayTest({0, 3, 0.5F}, {10, 3, 0.5F}, sweep, {-2.5F, -2.5F, -2.5F},
                       {2.5F, 2.5F, 2.5F});
  EXPECT_THAT(sweep.found, ElementsAre(a));
}

TEST_F(BulletBroadPhaseTest, QueriesFindProxiesThatCollideWithNothing) {
  btBroadphaseProxy* const no_mask = Add(0, kDefault, 0);
  btBroadphaseProxy* const no_group = Add(0, 0, kAll);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 0);
  Collector query;
  broad_phase_.aabbTest({0, 0, 0}, {1, 1, 1}, query);
  EXPECT_THAT(query.found, UnorderedElementsAre(no_mask, no_group));
}

TEST_F(BulletBroadPhaseTest, ACallbackCanCastRaysAndDestroyTheNextResult) {
  btBroadphaseProxy* const near = Add(2);
  btBroadphaseProxy* const far = Add(6);
  Collector inner;
  Collector outer;
  outer.on_found = [&] {
    broad_phase_.rayTest({10, 0.5F, 0.5F}, {0, 0.5F, 0.5F}, inner);
    broad_phase_.destroyProxy(far, nullptr);
  };
  broad_phase_.rayTest({0, 0.5F, 0.5F}, {10, 0.5F, 0.5F}, outer);
  EXPECT_THAT(inner.found, ElementsAre(far, near));
  EXPECT_THAT(outer.found, ElementsAre(near));
}

TEST_F(BulletBroadPhaseTest, ARayThatIsNotFiniteFindsNothing) {
  Add(0);
  Collector ray;
  broad_phase_.rayTest({0.5F, 0.5F, 0.5F}, {5, 0.5F, 0.5F}, ray);
  broad_phase_.rayTest({0.5F, 0.5F, 0.5F}, {std::numeric_limits<float>::infinity(), 0, 0}, ray);
  EXPECT_EQ(ray.found.size(), 1U);
}

// All boxes are within one subnormal number of zero.
TEST_F(BulletBroadPhaseTest, HasTheSameResultsInEveryFloatingPointEnvironment) {
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  constexpr float kThird = 1.0F / 3;
  const btVector3 zero(0, 0, 0);
  const btVector3 tiny(kTiny, kTiny, kTiny);
  const btVector3 three(3 * kTiny, 3 * kTiny, 3 * kTiny);
  const btVector3 from(-kThird, 0, 0);
  const btVector3 to(1e9F + kThird, kTiny, 0);
  for (const FloatMode& mode : FloatModes()) {
    btBroadphaseProxy* const a = broad_phase_.createProxy(zero, zero, 0, nullptr, 1, 1, nullptr);
    btBroadphaseProxy* const b = broad_phase_.createProxy(tiny, tiny, 0, nullptr, 1, 1, nullptr);
    btVector3 min;
    btVector3 max;
    Collector ray;
    EXPECT_TRUE(KeepsMode(mode, [&] {
      Step();
      broad_phase_.setAabb(a, tiny, tiny, nullptr);
      broad_phase_.setAabb(b, tiny, three, nullptr);
      Step();
      broad_phase_.getBroadphaseAabb(min, max);
      broad_phase_.rayTest(from, to, ray, zero, tiny);
    })) << mode.name;
    EXPECT_TRUE(AreKept(a, b)) << mode.name;
    EXPECT_TRUE(min == tiny && max == three) << mode.name;
    EXPECT_EQ(ray.found.size(), 2U) << mode.name;
    broad_phase_.destroyProxy(a, nullptr);
    broad_phase_.destroyProxy(b, nullptr);
  }
}

TEST_F(BulletBroadPhaseTest, TheBoundsContainAllBoxes) {
  btVector3 min;
  btVector3 max;
  broad_phase_.getBroadphaseAabb(min, max);
  EXPECT_TRUE(min.isZero() && max.isZero());
  Add(2);
  btBroadphaseProxy* const b = Add(6, kStatic, kAll ^ kStatic);
  broad_phase_.getBroadphaseAabb(min, max);
  EXPECT_EQ(min, btVector3(2, 0, 0));
  EXPECT_EQ(max, btVector3(7, 1, 1));
  broad_phase_.getAabb(b, min, max);
  EXPECT_EQ(min, btVector3(6, 0, 0));
  EXPECT_EQ(max, btVector3(7, 1, 1));
}

TEST_F(BulletBroadPhaseTest, ResetOfAnEmptyWorldRestartsTheIds) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0);
  const int first = a->m_uniqueId;
  broad_phase_.destroyProxy(a, nullptr);
  broad_phase_.resetPool(nullptr);  // has no effect, because b still exists
  EXPECT_EQ(broad_phase_.proxies().moving_count(), 1U);
  EXPECT_EQ(Add(5)->m_uniqueId, first);
  broad_phase_.destroyProxy(a, nullptr);
  broad_phase_.destroyProxy(b, nullptr);
  broad_phase_.resetPool(nullptr);
  EXPECT_EQ(broad_phase_.proxies().moving_boxes().size(), 0U);
  btBroadphaseProxy* const again = Add(0);
  EXPECT_EQ(again->m_uniqueId, first);
  EXPECT_NE(Add(0)->m_uniqueId, first);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
}

TEST(BulletMemoryTest, AProxyThatCannotBeAllocatedUsesNoId) {
  bool is_empty = false;
  Hooks hooks{.user = &is_empty};
  hooks.allocate = [](size_t bytes, size_t alignment, void* user) -> void* {
    if (*static_cast<bool*>(user)) return nullptr;
    return ::operator new (bytes, std::align_val_t{alignment});
  };
  hooks.release = [](void* pointer, size_t, size_t alignment, void*) {
    ::operator delete (pointer, std::align_val_t{alignment});
  };
  ASSERT_TRUE(SetHooks(hooks).ok());
  {
    const auto search = std::move(*AdaptiveBroadPhase::Create(OneArm("Grid"), nullptr));
    BulletBroadPhase broad_phase(*search);
    const auto add = [&] {
      return broad_phase.createProxy({0, 0, 0}, {1, 1, 1}, BOX_SHAPE_PROXYTYPE, nullptr, kDefault,
                                     kAll, nullptr);
    };
    is_empty = true;
    EXPECT_THROW(add(), std::bad_alloc);
    is_empty = false;
    EXPECT_EQ(add()->m_uniqueId, 1);
  }
  EXPECT_TRUE(SetHooks({}).ok());
}

TEST_F(BulletBroadPhaseTest, ASearchWithTooManyPairsKeepsTheCache) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0.5F);
  btBroadphaseProxy* const c = Add(0.7F);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 3);
  std::vector<btBroadphaseProxy*> crowd;
  for (size_t i = 0; i < kTooManyBoxes; ++i) crowd.push_back(Add(50));
  broad_phase_.destroyProxy(c, nullptr);
  for (int step = 0; step < 40; ++step) {  // from the thirtieth step on the crowd rests
    for (btBroadphaseProxy* const proxy : crowd) Move(proxy, 50);
    Step();
    ASSERT_TRUE(search_->pairs_exceeded()) << "in step " << step;
    ASSERT_EQ(cache().getNumOverlappingPairs(), 1);
  }
  EXPECT_TRUE(AreKept(a, b));
  for (btBroadphaseProxy* const proxy : crowd) broad_phase_.destroyProxy(proxy, nullptr);
  Move(a, 5);
  btBroadphaseProxy* const d = Add(0.7F);
  Step();
  EXPECT_FALSE(search_->pairs_exceeded());
  EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
  EXPECT_TRUE(AreKept(b, d));
}

TEST(BulletGhostTest, AGhostObjectFindsObjectsInItsBox) {
  btGhostPairCallback callback;  // The destructor of the world uses it, too.
  AdaptiveBulletGame played(OneArm("DBVT"), {.stack_height = 1});
  played.broad_phase().getOverlappingPairCache()->setInternalGhostPairCallback(&callback);
  btBoxShape room({2, 2, 2});
  btGhostObject ghost;
  ghost.setCollisionShape(&room);
  ghost.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
  btDiscreteDynamicsWorld& world = played.game().world();
  world.addCollisionObject(&ghost, btBroadphaseProxy::SensorTrigger,
                           btBroadphaseProxy::DefaultFilter);
  played.Step();
  EXPECT_EQ(ghost.getNumOverlappingObjects(), 1);
  ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0, 30, 0}));
  played.Step();
  EXPECT_EQ(ghost.getNumOverlappingObjects(), 0);
  world.removeCollisionObject(&ghost);
}

TEST(BulletFrameTest, TheSubstepsOfAFrameGiveOneSample) {
  AdaptiveBulletGame played(OneArm("SAP"), {.stack_height = 3});
  played.search().BeginFrame();
  for (int substep = 0; substep < 3; ++substep) played.game().Step();
  played.search().EndFrame({.frame_time_ns = 50'000'000});
  EXPECT_EQ(played.search().last_sample().frame_index, 0U);
  EXPECT_EQ(played.search().last_sample().object_count, 3U);
}

}  // namespace
}  // namespace sweepstake::test_support
