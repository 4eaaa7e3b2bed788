// The initial exploration runs every arm once in a seeded order: a warm-up, then the measurement.
// Both are counted in frame time.
#include "engine_client/decider/session/run_phases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

SessionSetup ExploringSetup(uint32_t arm_count, uint64_t seed = 1) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.explore = true;
  setup.seed = seed;
  return setup;
}

// Runs until the exploration is over.
void Explore(ScriptedClient& client) {
  while (client.session.exploring() && client.log.size() < 1'000) client.RunToTick();
}

TEST(ExplorationOrder, IsAPermutation) {
  for (uint32_t count = 1; count <= 32; ++count) {
    std::vector<uint32_t> order = ExplorationOrder(count, count);
    std::sort(order.begin(), order.end());
    for (uint32_t arm = 0; arm < count; ++arm) EXPECT_EQ(order[arm], arm);
  }
}

TEST(ExplorationOrder, IsFixedByTheSeed) {
  EXPECT_EQ(ExplorationOrder(9, 7), ExplorationOrder(9, 7));
  std::set<std::vector<uint32_t>> orders;
  for (uint64_t seed = 0; seed < 100; ++seed) orders.insert(ExplorationOrder(seed, 7));
  EXPECT_GT(orders.size(), 95u);
}

TEST(ExplorationOrder, PutsEveryArmFirstEquallyOften) {
  std::vector<int> first(7);
  for (uint64_t seed = 0; seed < 7'000; ++seed) ++first[ExplorationOrder(seed, 7)[0]];
  for (const int count : first) EXPECT_NEAR(count, 1'000, 150);
}

TEST(Exploration, VisitsEveryArmOnceInTheSeededOrder) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    ScriptedClient client(ExploringSetup(7, seed));
    Explore(client);
    std::vector<uint32_t> visited;
    for (const Decision& decision : client.log) {
      if (!decision.increment) continue;
      const uint32_t arm = decision.increment->arm;
      if (visited.empty() || visited.back() != arm) visited.push_back(arm);
    }
    EXPECT_EQ(visited, ExplorationOrder(seed, 7));
    EXPECT_EQ(client.session.explored_arm_count(), 7u);
  }
}

TEST(Exploration, SwitchesWithoutCooldownAndWithItsOwnReason) {
  ScriptedClient client(ExploringSetup(7));
  Explore(client);
  EXPECT_LT(client.now_ns, 7 * 10 * kSecond);
  EXPECT_GE(client.commands.size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(client.commands[i].reason, SwitchReason::kExploration);
}

TEST(Exploration, OmitsTheWarmUpAndMeasuresFourSecondsOfEachArm) {
  ScriptedClient client(ExploringSetup(7));
  Explore(client);
  for (uint32_t arm = 0; arm < 7; ++arm) {
    // At least 4 s are measured in ticks of 2 s: two or three windows of reward 0.937.
    const double evidence = client.session.posteriors()[arm].evidence();
    EXPECT_GE(evidence, 4 - 1e-9);
    EXPECT_LE(evidence, 5 + 1e-9);
  }
  for (const Decision& decision : client.log) {
    if (decision.increment) {
      EXPECT_NEAR(*decision.record.reward, 0.937, 1e-9);
    }
  }
}

TEST(Exploration, WarmUpReplacesSettling) {
  SessionSetup setup = ExploringSetup(1);
  setup.options.settling_ns = 20 * kSecond;
  ScriptedClient client(setup);
  Explore(client);
  EXPECT_EQ(client.session.counts().settling_frame_count, 201u);
  setup.options.settling_ns = 0;
  ScriptedClient unsettled(setup);
  Explore(unsettled);
  EXPECT_EQ(unsettled.session.counts().settling_frame_count, 201u);
}

TEST(Exploration, TicksHaveTheOutcomeExploringAndNoDraws) {
  ScriptedClient client(ExploringSetup(3));
  Explore(client);
  for (size_t i = 0; i + 1 < client.log.size(); ++i) {
    EXPECT_EQ(client.log[i].record.outcome, DecisionOutcome::kExploring);
    EXPECT_FALSE(client.log[i].record.candidate);
  }
}

TEST(Exploration, DoesNotEndASlotWithoutFrames) {
  ScriptedClient client(ExploringSetup(3));
  client.RunTicks(2);
  const uint32_t explored = client.session.explored_arm_count();
  for (int i = 0; i < 100; ++i) {
    const Decision decision = client.session.Tick(client.session.next_tick_ns());
    EXPECT_FALSE(decision.command);
  }
  EXPECT_EQ(client.session.explored_arm_count(), explored);
}

TEST(Exploration, EndsWithAnOrdinaryTickAndTheCooldownOfTheLastSwitch) {
  SessionSetup setup = ExploringSetup(2);
  const uint32_t last = ExplorationOrder(setup.seed, 2)[1];
  setup.priors.assign(2, {1e6, 1});
  setup.priors[last] = {1, 1e6};  // so the other arm is always the candidate
  ScriptedClient client(setup);
  Explore(client);
  const Decision& ending = client.log.back();
  EXPECT_EQ(ending.record.outcome, DecisionOutcome::kHeldCooldown);
  EXPECT_EQ(ending.record.candidate, 1 - last);
  EXPECT_TRUE(ending.increment);
  EXPECT_EQ(client.session.observation(client.now_ns).start_ns, client.now_ns);
  int64_t last_switch_ns = 0;
  for (const Decision& decision : client.log) {
    if (decision.command) last_switch_ns = decision.record.time_ns;
  }
  const size_t explored = client.commands.size();
  for (int i = 0; i < 100 && client.commands.size() == explored; ++i) client.RunToTick();
  ASSERT_EQ(client.commands.size(), explored + 1);
  EXPECT_EQ(client.commands.back().reason, SwitchReason::kPolicy);
  EXPECT_EQ(client.now_ns - last_switch_ns, 40 * kSecond);
}

TEST(Exploration, ContinuesAfterARestart) {
  SessionSetup setup = ExploringSetup(5);
  const std::vector<uint32_t> order = ExplorationOrder(setup.seed, 5);
  setup.explored_arm_count = 3;
  setup.decision_count = 12;
  setup.active_arm = order[3];
  ScriptedClient client(setup);
  Explore(client);
  ASSERT_EQ(client.commands.size(), 1u);
  EXPECT_EQ(client.commands[0].arm, order[4]);
}

TEST(Exploration, NeedsNoCommandForTheActiveArm) {
  SessionSetup setup = ExploringSetup(1);
  ScriptedClient client(setup);
  Explore(client);
  EXPECT_TRUE(client.commands.empty());
  EXPECT_EQ(client.session.explored_arm_count(), 1u);
}

TEST(Exploration, SkipsAnArmAfterThreeUnansweredCommands) {
  ScriptedClient client(ExploringSetup(3));
  client.obedient = false;
  client.arm = client.session.active_arm();
  Explore(client);
  std::vector<uint32_t> commanded;
  for (const SwitchCommand& command : client.commands) commanded.push_back(command.arm);
  for (uint32_t arm = 0; arm < 3; ++arm) {
    const auto count = std::count(commanded.begin(), commanded.end(), arm);
    EXPECT_EQ(count, arm == client.arm ? 0 : 3) << arm;
  }
  EXPECT_FALSE(client.session.exploring());
}

TEST(Exploration, IsSuspendedInManualMode) {
  ScriptedClient client(ExploringSetup(3));
  client.RunTicks(5);
  const uint32_t explored = client.session.explored_arm_count();
  client.session.SetMode(Mode::kManual, client.arm, client.now_ns);
  client.RunTicks(20);
  EXPECT_EQ(client.session.explored_arm_count(), explored);
  client.session.SetMode(Mode::kAi, client.arm, client.now_ns);
  Explore(client);
  EXPECT_EQ(client.session.explored_arm_count(), 3u);
}

TEST(Exploration, IsSkippedIfTheOptionsSaySo) {
  ScriptedClient client(PlainSetup(3));
  EXPECT_FALSE(client.session.exploring());
  EXPECT_EQ(client.session.observation(0).start_ns, 0);
}

}  // namespace
}  // namespace sweepstake::decision
