#include "engine_client/decider/pooling/scene_pool.h"

#include <gtest/gtest.h>

#include <string>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/priors_groups.h"

namespace sweepstake::decision {
namespace {

TEST(PoolScene, PoolsTheNewestVersionsTogetherAndOthersAlone) {
  const VersionEvidence versions[] = {{"Grid", 1, {.live = {3, 1}, .lane = {90, 10}}},
                                      {"Grid", 2, {.live = {60, 40}, .window_count = 50}},
                                      {"SAP", 1, {.live = {50, 50}, .lane = {700, 300}}},
                                      {"SAP", 2, {.live = {1, 99}, .bail_out_count = 1}}};
  const PooledScene scene = PoolScene(versions);
  const ArmEvidence newest[] = {versions[1].evidence, versions[3].evidence};
  EXPECT_EQ(scene.pooled[1].alpha, PoolEvidence(newest)[0].alpha);
  EXPECT_EQ(scene.pooled[3].beta, PoolEvidence(newest)[1].beta);
  EXPECT_EQ(scene.pooled[2].alpha, PoolEvidence({&versions[2].evidence, 1})[0].alpha);
  EXPECT_EQ(scene.arms[1].posterior, (BetaPosterior{61, 41}));
  EXPECT_EQ(scene.window_evidence, 204.0 / 50) << "(4 + 100 + 100) without the bail-out";
}

// Three readers must name the same leader: LeaderOf for the preview of a change, GroupPriors with a
// cost ratio of 1, and DiagnoseScene for the dashboard. In the first case, an arm with little
// evidence has the highest mean reward (0.65) but does not lead. In the second case, the leader's
// posterior mean is only 0.55.
TEST(PoolScene, AllReadersNameTheSameLeader) {
  const auto leader_is = [](const std::string& expected, const std::vector<PriorRecord>& records) {
    std::vector<VersionEvidence> versions;
    for (const PriorRecord& record : records)
      versions.push_back({record.key.arm, 1, EvidenceBy({}, record.evidence)});
    const PooledScene scene = PoolScene(versions);
    const std::optional<size_t> leader = LeaderOf(scene.arms, kLogCostRewardVersion);
    ASSERT_TRUE(leader);
    EXPECT_EQ(scene.arms[*leader].name, expected);
    EXPECT_EQ(DiagnoseScene(scene.arms, kLogCostRewardVersion).leader, leader);
    const PriorsGroups groups = GroupPriors(records);
    for (const auto& [name, arm] : groups.begin()->second.arms)
      EXPECT_EQ(arm.cost_ratio == CostRatio{}, name == expected) << name;
  };
  const auto record = [](const std::string& arm, double alpha, double beta) {
    return PriorRecord{.key = {.project = "arcade",
                               .scene = "arena",
                               .measured_by = {},
                               .arm = arm,
                               .machine_class = "test",
                               .reward_version = kLogCostRewardVersion},
                       .source_id = "s",
                       .source_sequence = 1,
                       .evidence = {.alpha = alpha, .beta = beta}};
  };
  leader_is("Grid", {record("Grid", 60, 40), record("SAP", 0.65, 0.35)});
  leader_is("SAP",
            {record("Grid", 60, 40), record("KDTree", 59.9, 40.1), record("SAP", 0.65, 0.35)});
  leader_is("SAP", {record("Grid", 60, 40), record("SAP", 0.9, 0.1)});
}

}  // namespace
}  // namespace sweepstake::decision
