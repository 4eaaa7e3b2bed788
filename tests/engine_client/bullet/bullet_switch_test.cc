// A switch never changes the game. A world whose arm changes at random every second equals a world
// with one arm to the last bit, with any number of threads. Multiplayer games need this, because
// all players must see the same world.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/support/bullet/adaptive_bullet_game.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::test_support {
namespace {

constexpr BulletGameOptions kSmallWorld{.stack_height = 4,
                                        .pile_count = 16,
                                        .chain_count = 2,
                                        .lift_count = 2,
                                        .visitor_interval = 23,
                                        .visitor_limit = 12,
                                        .blow_interval = 420,
                                        .phase_interval = 50,
                                        .query_interval = 7,
                                        .half_width = 5};
// Enough boxes for backends and proxies to divide their work among threads.
constexpr BulletGameOptions kLargeWorld{
    .pile_count = 3000, .visitor_interval = 2, .phase_interval = 12};

int StepCount() { return static_cast<int>(FromEnvironment("TEST_STEPS", 900)); }

// A game with all arms that now and then selects another arm at random. It selects either by hand,
// which takes effect in the next frame, or by a command. A command waits until the shadow lane has
// prepared the arm, if there is a lane.
class SwitchingGame {
 public:
  SwitchingGame(int switch_interval, const BulletGameOptions& options, Executor* executor = nullptr)
      : switch_interval_(switch_interval), played_({.executor = executor}, options) {}

  void Step() {
    if (played_.game().step_count() % switch_interval_ == 0) Switch();
    played_.Step();
  }

  uint64_t state_hash() { return played_.game().state_hash(); }
  uint32_t switch_count() { return played_.search().switch_epoch(); }

 private:
  void Switch() {
    AdaptiveBroadPhase& search = played_.search();
    const auto arm = static_cast<uint32_t>(random_() % search.arms().size());
    if (random_() % 2 == 0) {
      EXPECT_TRUE(search.SelectArm(search.arms()[arm]).ok());
    } else {
      search.mailbox().Post({.command_id = 1, .arm = arm});
    }
  }

  const int switch_interval_;
  AdaptiveBulletGame played_;
  std::minstd_rand random_{static_cast<uint32_t>(FromEnvironment("TEST_SEED", 1))};
};

// Describes the first step after which the games differ; empty if there is none.
std::string FirstDifference(SwitchingGame& switching, AdaptiveBulletGame& fixed, int steps) {
  for (int step = 0; step < steps; ++step) {
    switching.Step();
    fixed.Step();
    if (switching.state_hash() != fixed.game().state_hash()) return "step " + std::to_string(step);
  }
  return {};
}

class BulletArmTest : public ::testing::TestWithParam<std::string_view> {};

TEST_P(BulletArmTest, GivesTheSameGameAsArmsThatChangeEverySecond) {
  AdaptiveBulletGame fixed(OneArm(GetParam()), kSmallWorld);
  SwitchingGame switching(/*switch_interval=*/60, kSmallWorld);
  EXPECT_EQ(FirstDifference(switching, fixed, StepCount()), "");
  EXPECT_GT(static_cast<int>(switching.switch_count()), StepCount() / 60 / 2);
}

INSTANTIATE_TEST_SUITE_P(Each, BulletArmTest, ::testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& arm) { return std::string(arm.param); });

class BulletThreadsTest : public ::testing::TestWithParam<size_t> {};

TEST_P(BulletThreadsTest, GiveTheSameSmallGame) {
  const std::unique_ptr<Executor> pool = MakeThreadPool(GetParam());
  AdaptiveBulletGame fixed(OneArm("BruteForce"), kSmallWorld);
  SwitchingGame switching(/*switch_interval=*/60, kSmallWorld, pool.get());
  EXPECT_EQ(FirstDifference(switching, fixed, StepCount()), "");
}

TEST_P(BulletThreadsTest, GiveTheSameLargeGame) {
  const std::unique_ptr<Executor> pool = MakeThreadPool(GetParam());
  AdaptiveBulletGame fixed(OneArm("DBVT"), kLargeWorld);
  SwitchingGame switching(/*switch_interval=*/3, kLargeWorld, pool.get());
  EXPECT_EQ(FirstDifference(switching, fixed, StepCount() / 50), "");
}

INSTANTIATE_TEST_SUITE_P(Of, BulletThreadsTest, ::testing::Values(1, 2, 4),
                         [](const auto& count) { return std::to_string(count.param); });

}  // namespace
}  // namespace sweepstake::test_support
