// Compares worlds of Bullet on our broad phase and on Bullet's own: the pairs of each step, and the
// final world to the last bit.
#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "tests/support/bullet/adaptive_bullet_game.h"
#include "tests/support/bullet/exact_broad_phase.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::test_support {
namespace {

using IdPairs = std::vector<std::pair<int, int>>;

struct World {
  const char* name;
  BulletGameOptions options;
};

const World kWorlds[] = {
    {"FallingStack", {.stack_height = 12}},
    {"Pile", {.pile_count = 150, .query_interval = 7, .half_width = 5}},
    {"Chains", {.chain_count = 6, .query_interval = 5, .half_width = 6}},
    {"ComingAndGoing", {.visitor_interval = 3, .visitor_limit = 40, .query_interval = 5}},
    {"SleepAndBlows",
     {.stack_height = 5,
      .pile_count = 30,
      .chain_count = 2,
      .blow_interval = 200,
      .half_width = 5}},
    {"Everything",
     {.stack_height = 5,
      .pile_count = 30,
      .chain_count = 2,
      .lift_count = 3,
      .visitor_interval = 11,
      .blow_interval = 240,
      .query_interval = 9,
      .half_width = 6}},
};

BulletGameOptions Sorted(BulletGameOptions options) {
  options.sorts_pairs = true;
  return options;
}

int IdOf(const btBroadphaseProxy* proxy) {
  return static_cast<btCollisionObject*>(proxy->m_clientObject)->getUserIndex();
}

IdPairs PairsInCache(BulletGame& game) {
  const btBroadphasePairArray& kept = game.world().getPairCache()->getOverlappingPairArray();
  IdPairs pairs;
  for (int i = 0; i < kept.size(); ++i) {
    pairs.push_back(std::minmax({IdOf(kept[i].m_pProxy0), IdOf(kept[i].m_pProxy1)}));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// The pairs by definition: boxes overlap and groups match.
IdPairs PairsByDefinition(BulletGame& game) {
  const std::span<const Aabb> boxes = game.boxes();
  const btCollisionObjectArray& objects = game.world().getCollisionObjectArray();
  IdPairs pairs;
  for (int a = 0; a < objects.size(); ++a) {
    btBroadphaseProxy* const proxy_a = objects[a]->getBroadphaseHandle();
    for (int b = a + 1; b < objects.size(); ++b) {
      btBroadphaseProxy* const proxy_b = objects[b]->getBroadphaseHandle();
      if (Overlap(boxes[static_cast<size_t>(a)], boxes[static_cast<size_t>(b)]) &&
          game.world().getPairCache()->needsBroadphaseCollision(proxy_a, proxy_b)) {
        pairs.push_back(std::minmax({objects[a]->getUserIndex(), objects[b]->getUserIndex()}));
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Describes the first step in which the worlds differ; empty if there is none.
std::string FirstDifference(AdaptiveBulletGame& ours, BulletGame& theirs, int steps) {
  for (int step = 0; step < steps; ++step) {
    ours.Step();
    theirs.Step();
    const std::string in_step = " in step " + std::to_string(step);
    if (PairsInCache(ours.game()) != PairsInCache(theirs)) return "other pairs" + in_step;
    if (ours.game().state_hash() != theirs.state_hash()) return "another world" + in_step;
  }
  return {};
}

uint64_t StepCount() { return FromEnvironment("TEST_STEPS", 300); }

class BulletWorldTest : public ::testing::TestWithParam<World> {};

TEST_P(BulletWorldTest, EachArmFindsThePairsOfTheDefinitionInEachStep) {
  for (const std::string_view arm : BroadPhaseNames()) {
    AdaptiveBulletGame played(OneArm(arm), GetParam().options);
    for (uint64_t step = 0; step < StepCount() / 3; ++step) {
      played.Step();
      ASSERT_EQ(PairsInCache(played.game()), PairsByDefinition(played.game()))
          << arm << " in step " << step;
    }
  }
}

TEST_P(BulletWorldTest, IsTheSameAsWithTheSimpleBroadPhase) {
  ExactBroadPhase<btSimpleBroadphase> simple(/*maxProxies=*/16384);
  BulletGame theirs(simple, Sorted(GetParam().options));
  AdaptiveBulletGame ours(OneArm("Grid"), Sorted(GetParam().options));
  EXPECT_EQ(FirstDifference(ours, theirs, static_cast<int>(StepCount())), "");
}

TEST_P(BulletWorldTest, IsTheSameAsWithTheDynamicTree) {
  ExactBroadPhase<btDbvtBroadphase> tree;
  BulletGame theirs(tree, Sorted(GetParam().options));
  AdaptiveBulletGame ours(OneArm("DBVT"), Sorted(GetParam().options));
  EXPECT_EQ(FirstDifference(ours, theirs, static_cast<int>(StepCount())), "");
}

TEST_P(BulletWorldTest, IsTheSameAsWithTheSweepOfThreeAxes) {
  ExactBroadPhase<btAxisSweep3> sweep(btVector3(-100, -100, -100), btVector3(100, 100, 100));
  BulletGame theirs(sweep, Sorted(GetParam().options));
  AdaptiveBulletGame ours(OneArm("SAP"), Sorted(GetParam().options));
  EXPECT_EQ(FirstDifference(ours, theirs, static_cast<int>(StepCount())), "");
}

INSTANTIATE_TEST_SUITE_P(All, BulletWorldTest, ::testing::ValuesIn(kWorlds),
                         [](const auto& world) { return world.param.name; });

// The comparisons above depend on sleeping bodies and blows, so check that both occur.
TEST(BulletGameTest, BodiesFallAsleepAndBlowsWakeThem) {
  AdaptiveBulletGame played(OneArm("KDTree"),
                            {.stack_height = 3, .pile_count = 10, .blow_interval = 900});
  int most_asleep = 0;
  for (int step = 0; step < 900; ++step) {
    played.Step();
    most_asleep = std::max(most_asleep, played.game().sleeping_count());
  }
  EXPECT_GT(most_asleep, 8);
  played.Step();
  EXPECT_LT(played.game().sleeping_count(), most_asleep);
}

// Tests the whole pile in a longer run: TEST_BODIES=5000.
TEST(BulletPileTest, ALargePileIsTheSameAsWithTheDynamicTree) {
  const auto bodies = static_cast<int>(FromEnvironment("TEST_BODIES", 600));
  const BulletGameOptions options = Sorted(PileOf(bodies));
  ExactBroadPhase<btDbvtBroadphase> tree;
  BulletGame theirs(tree, options);
  AdaptiveBulletGame ours({.initial_arm = "Tracy", .shadow = {.enabled = ShadowMode::kOff}},
                          options);
  EXPECT_EQ(FirstDifference(ours, theirs, static_cast<int>(StepCount() / 2)), "");
}

}  // namespace
}  // namespace sweepstake::test_support
