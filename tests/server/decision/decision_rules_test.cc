// Every row of the selector's table, by name, on a scripted clock.
#include <gtest/gtest.h>

#include <set>

#include "server/decision/decision_session.h"
#include "tests/server/decision/scripted_client.h"

namespace sweepstake::decision {
namespace {

SessionSetup ExploringSetup(uint32_t arm_count, uint64_t seed) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.explore = true;
  setup.seed = seed;
  return setup;
}

TEST(Update, AddsTheRewardToAlphaAndItsComplementToBetaOfTheActiveArmOnly) {
  SessionSetup setup = PlainSetup(3);
  setup.active_arm = 1;
  setup.options.cooldown_ns = 0;
  setup.options.policy = "paper";
  ScriptedClient client(setup);
  client.obedient = false;
  client.Settle();
  const std::vector<BetaPosterior> before(client.session.posteriors().begin(),
                                          client.session.posteriors().end());
  const Decision decision = client.RunToTick();
  ASSERT_TRUE(decision.record.reward);
  const auto after = client.session.posteriors();
  EXPECT_EQ(after[0], before[0]);
  EXPECT_EQ(after[2], before[2]);
  EXPECT_DOUBLE_EQ(after[1].alpha, before[1].alpha + *decision.record.reward);
  EXPECT_DOUBLE_EQ(after[1].beta, before[1].beta + 1 - *decision.record.reward);
  EXPECT_EQ(decision.increment->arm, 1u);
  EXPECT_EQ(decision.increment->window_count, 1u);
}

TEST(Exploration, VisitsEveryArmOnceInASeededOrder) {
  std::set<std::vector<uint32_t>> orders;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    ScriptedClient client(ExploringSetup(7, seed));
    std::vector<uint32_t> order;
    while (client.session.exploring()) {
      client.RunToTick();
      if (client.log.back().increment && (order.empty() || order.back() != client.arm))
        order.push_back(client.log.back().increment->arm);
      ASSERT_LT(client.log.size(), 60u);
    }
    EXPECT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), 7u);
    orders.insert(order);
  }
  EXPECT_GT(orders.size(), 5u);
}

}  // namespace
}  // namespace sweepstake::decision
