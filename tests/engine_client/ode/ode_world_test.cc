// Compares worlds of ODE on our broad phase and on ODE's own spaces: the calls of the near callback
// in each step, and the world to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "tests/support/ode/adaptive_ode_game.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::test_support {
namespace {

struct World {
  const char* name;
  OdeGameOptions options;
};

const World kWorlds[] = {
    {"Pile", {.pile_count = 60, .half_width = 3}},
    {"Chains", {.chain_count = 5, .scenery_count = 20}},
    {"Everything",
     {.pile_count = 40,
      .chain_count = 2,
      .scenery_count = 20,
      .event_interval = 3,
      .half_width = 4}},
};

int StepCount() { return static_cast<int>(FromEnvironment("TEST_STEPS", 240)); }

// Describes the first step after which the games differ; empty if there is none.
template <typename Ours, typename Theirs>
std::string FirstDifference(Ours& ours, Theirs& theirs) {
  for (int step = 0; step < StepCount(); ++step) {
    ours.Step();
    theirs.Step();
    const std::string in_step = " in step " + std::to_string(step);
    if (ours.game().calls() != theirs.game().calls()) return "other calls" + in_step;
    if (ours.game().state_hash() != theirs.game().state_hash()) return "another world" + in_step;
  }
  return {};
}

class OdeWorldTest : public ::testing::TestWithParam<World> {};

TEST_P(OdeWorldTest, IsTheSameAsWithTheSimpleSpaceWithEachArm) {
  for (const std::string_view arm : BroadPhaseNames()) {
    OwnOdeGame theirs(GetParam().options);
    AdaptiveOdeGame ours(OneArm(arm), GetParam().options);
    EXPECT_EQ(FirstDifference(ours, theirs), "") << arm;
    EXPECT_GT(ours.game().contact_count(), StepCount());
  }
}

TEST_P(OdeWorldTest, IsTheSameWhenTheArmChangesEverySecond) {
  OwnOdeGame theirs(GetParam().options);
  AdaptiveOdeGame ours({.shadow = {.enabled = ShadowMode::kOff}}, GetParam().options);
  AdaptiveBroadPhase& search = ours.search();
  for (int step = 0; step < StepCount(); ++step) {
    if (step % 60 == 0) {
      ASSERT_TRUE(search.SelectArm(search.arms()[static_cast<size_t>(step) / 60 % 7]).ok());
    }
    ours.Step();
    theirs.Step();
    ASSERT_EQ(ours.game().calls(), theirs.game().calls()) << "step " << step;
    ASSERT_EQ(ours.game().state_hash(), theirs.game().state_hash()) << "step " << step;
  }
  EXPECT_GT(static_cast<int>(search.switch_epoch()), StepCount() / 60 / 2);
}

OdeGame::Calls Sorted(OdeGame::Calls calls) {
  for (auto& [a, b] : calls) {
    if (a > b) std::swap(a, b);
  }
  std::sort(calls.begin(), calls.end());
  return calls;
}

// The order of a hash space depends on its table, so only the sets are compared. ODE 0.16.2 misses
// some pairs (see ode_peers.cc), at most one in a hundred.
TEST_P(OdeWorldTest, HasThePairsOfTheHashSpace) {
  OdeGameOptions options = GetParam().options;
  options.make_space = dHashSpaceCreate;
  const auto search = std::move(*AdaptiveBroadPhase::Create(OneArm("KDTree"), nullptr));
  OdeGame game(options);
  OdeBroadPhase ours(*search, game.space());
  size_t pair_count = 0;
  size_t missed_count = 0;
  for (int step = 0; step < StepCount(); ++step) {
    OdeGame::Calls theirs;
    search->BeginFrame();
    game.Step([&](void* data, dNearCallback* callback) {
      dSpaceCollide(game.space(), &theirs, [](void* calls, dGeomID a, dGeomID b) {
        static_cast<OdeGame::Calls*>(calls)->emplace_back(OdeGame::IdOf(a), OdeGame::IdOf(b));
      });
      ours.Collide(data, callback);
    });
    search->EndFrame({});
    const OdeGame::Calls all = Sorted(game.calls());
    theirs = Sorted(theirs);
    ASSERT_TRUE(std::includes(all.begin(), all.end(), theirs.begin(), theirs.end()))
        << "step " << step;
    pair_count += all.size();
    missed_count += all.size() - theirs.size();
  }
  EXPECT_LE(missed_count * 100, pair_count);
}

INSTANTIATE_TEST_SUITE_P(All, OdeWorldTest, ::testing::ValuesIn(kWorlds),
                         [](const auto& world) { return world.param.name; });

// The comparisons above depend on sleeping bodies and on events, so check that they occur.
TEST(OdeGameTest, BodiesFallAsleepAndGeomsComeAndGo) {
  OwnOdeGame played({.pile_count = 12, .event_interval = 3});
  const int geom_count = played.game().geom_count();
  int most_asleep = 0;
  for (int step = 0; step < 240; ++step) {
    played.Step();
    most_asleep = std::max(most_asleep, played.game().sleeping_count());
  }
  EXPECT_GT(most_asleep, 3);
  EXPECT_NE(played.game().geom_count(), geom_count);
}

}  // namespace
}  // namespace sweepstake::test_support
