// Tests which overlapping boxes form a pair, and what happens if the filters change.
#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "tests/support/bullet/bullet_broad_phase_fixture.h"

namespace sweepstake::test_support {
namespace {

class BulletFilterTest : public BulletBroadPhaseTest {};

class RefuseAll final : public btOverlapFilterCallback {
 public:
  bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override {
    return false;
  }
};

class LetAllPass final : public btOverlapFilterCallback {
 public:
  bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override {
    return true;
  }
};

class LetThoseWithAMaskPass final : public btOverlapFilterCallback {
 public:
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    return a->m_collisionFilterMask != 0 && b->m_collisionFilterMask != 0;
  }
};

TEST_F(BulletFilterTest, APairPassesIfEachGroupIsInTheMaskOfTheOther) {
  constexpr int kOwnGroup = 64;
  btBroadphaseProxy* const plain = Add(0);
  btBroadphaseProxy* const shy = Add(0, kOwnGroup, kOwnGroup);
  btBroadphaseProxy* const other_shy = Add(0, kOwnGroup, kOwnGroup);
  btBroadphaseProxy* const last_bit = Add(0, std::numeric_limits<int>::min(), kDefault);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 2);
  EXPECT_TRUE(AreKept(shy, other_shy));
  EXPECT_TRUE(AreKept(plain, last_bit));
}

TEST_F(BulletFilterTest, AChangedMaskAppliesFromTheNextBox) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0, kDefault, kStatic);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  b->m_collisionFilterMask = kAll;
  Move(b, 0);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletFilterTest, AMaskOrGroupOfZeroEndsPairsUntilItIsRestored) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0);
  btBroadphaseProxy* const c = Add(0);
  Step();
  for (int* const bits : {&b->m_collisionFilterMask, &b->m_collisionFilterGroup}) {
    const int before = std::exchange(*bits, 0);
    Move(b, 0);
    Step();
    EXPECT_EQ(cache().getNumOverlappingPairs(), 1);
    EXPECT_TRUE(AreKept(a, c));
    *bits = before;
    Move(b, 0);
    Step();
    EXPECT_EQ(cache().getNumOverlappingPairs(), 3);
  }
}

TEST_F(BulletFilterTest, AProxyAddedWithMaskZeroFormsPairsOnceItHasAMask) {
  btBroadphaseProxy* const a = Add(0, kDefault, 0);
  btBroadphaseProxy* const b = Add(0);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  a->m_collisionFilterMask = kAll;
  Move(a, 0.5F);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletFilterTest, APairThatStillMatchesAfterAMaskChangeKeepsItsContacts) {
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0);
  Step();
  int contacts = 0;
  cache().findPair(a, b)->m_internalInfo1 = &contacts;
  a->m_collisionFilterMask = kDefault;
  Move(a, 0);
  Step();
  EXPECT_EQ(cache().findPair(a, b)->m_internalInfo1, &contacts);
}

TEST_F(BulletFilterTest, ANewFilterCallbackAppliesToExistingPairs) {
  RefuseAll none;
  cache().setOverlapFilterCallback(&none);
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  cache().setOverlapFilterCallback(nullptr);
  Step();
  EXPECT_TRUE(AreKept(a, b));
  cache().setOverlapFilterCallback(&none);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  LetAllPass all;
  cache().setOverlapFilterCallback(&all);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletFilterTest, AMaskChangeCallsTheFilterCallbackAgain) {
  LetThoseWithAMaskPass callback;
  cache().setOverlapFilterCallback(&callback);
  btBroadphaseProxy* const a = Add(0);
  btBroadphaseProxy* const b = Add(0, kDefault, 0);
  Step();
  EXPECT_FALSE(AreKept(a, b));
  b->m_collisionFilterMask = kStatic;
  Move(b, 0);
  Step();
  EXPECT_TRUE(AreKept(a, b));
}

TEST_F(BulletFilterTest, AFilterCallbackReplacesGroupsAndMasks) {
  RefuseAll none;
  cache().setOverlapFilterCallback(&none);
  btBroadphaseProxy* const a = Add(0);
  Step();
  btBroadphaseProxy* const b = Add(0, kDefault, kStatic);
  Step();
  EXPECT_EQ(cache().getNumOverlappingPairs(), 0);
  LetAllPass all;
  cache().setOverlapFilterCallback(&all);
  Move(b, 5);
  Step();
  Move(b, 0);
  Step();
  EXPECT_TRUE(AreKept(a, b));  // although the groups forbid it
  cache().setOverlapFilterCallback(nullptr);
  Step();
  EXPECT_FALSE(AreKept(a, b));
}

// Games do this when they break a wall, or freeze objects that have fallen.
TEST_F(BulletFilterTest, AChangedGroupMakesARestingProxyStaticOrMoving) {
  constexpr int kNotStatic = kAll ^ kStatic;
  btBroadphaseProxy* const a = Add(0, kStatic, kNotStatic);
  btBroadphaseProxy* const b = Add(0, kStatic, kNotStatic);
  const auto change_to = [&](int group, int mask) {
    for (btBroadphaseProxy* const proxy : {a, b}) {
      proxy->m_collisionFilterGroup = group;
      proxy->m_collisionFilterMask = mask;
      Move(proxy, 0);
    }
    Step();
  };
  Step();
  change_to(kDefault, kAll);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 0U);
  EXPECT_TRUE(AreKept(a, b));
  for (int step = 1; step < 30; ++step) change_to(kDefault, kAll);
  EXPECT_EQ(SleepingCount(), 2);
  change_to(kStatic, kNotStatic);
  EXPECT_EQ(broad_phase_.proxies().static_count(), 2U);
  EXPECT_FALSE(AreKept(a, b));
}

}  // namespace
}  // namespace sweepstake::test_support
