#include "engine_client/decider/policy/scene_diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

TEST(SceneDiagnosis, ComparesRewardsWithDiagnose) {
  const std::vector<SceneArm> arms = {{"SAP", 2, {30, 10}}, {"Grid", 1, {5, 35}}};
  const SceneDiagnosis scene = DiagnoseScene(arms, 2);
  const std::vector<BetaPosterior> posteriors = {{30, 10}, {5, 35}};
  const Diagnosis expected = Diagnose(posteriors);
  EXPECT_EQ(scene.leader, 0u);
  EXPECT_EQ(scene.verdict, Verdict::kStable);
  EXPECT_EQ(scene.expected_loss_ratio, expected.expected_loss_ratio);
  EXPECT_EQ(scene.value_remaining_ratio, expected.value_remaining_ratio);
  for (size_t i = 0; i < arms.size(); ++i) {
    EXPECT_EQ(scene.arms[i].best_probability, expected.best_probability[i]);
    EXPECT_FALSE(scene.arms[i].cost_ratio) << "these rewards do not measure costs";
  }
}

// Rewards of version 3 are logarithms of costs. The range from 0 to 1 corresponds to ln(5e9), about
// 22.3.
TEST(SceneDiagnosis, GivesCostRatiosIfTheRewardsMeasureCosts) {
  const std::vector<SceneArm> arms = {{"SAP", 1, {60'000, 40'000}}, {"Grid", 1, {58'000, 42'000}}};
  const SceneDiagnosis scene = DiagnoseScene(arms, kLogCostRewardVersion);
  EXPECT_EQ(scene.arms[0].cost_ratio, CostRatio{});
  ASSERT_TRUE(scene.arms[1].cost_ratio);
  EXPECT_NEAR(scene.arms[1].cost_ratio->median, std::exp(0.02 * std::log(5e9)), 1e-6);
  EXPECT_LT(scene.arms[1].cost_ratio->low, scene.arms[1].cost_ratio->median);
  EXPECT_GT(scene.arms[1].cost_ratio->high, scene.arms[1].cost_ratio->median);
}

// For two equal arms the expected loss is 0.4 standard deviations of the difference of their
// log-costs.
TEST(SceneDiagnosis, TheExpectedLossIsAShareOfTheCost) {
  const std::vector<SceneArm> arms = {{"SAP", 1, {60'000, 40'000}}, {"Grid", 1, {60'000, 40'000}}};
  const double deviation = std::sqrt(2 * 0.6 * 0.4 / 100'001) * std::log(5e9);
  EXPECT_NEAR(DiagnoseScene(arms, kLogCostRewardVersion).expected_loss_ratio,
              deviation / std::sqrt(2 * std::acos(-1.0)), 1e-3);
}

TEST(SceneDiagnosis, ComparesTheNewestVersionOfEachArm) {
  const std::vector<SceneArm> arms = {
      {"SAP", 1, {900, 100}}, {"SAP", 2, {400, 600}}, {"Grid", 1, {700, 300}}};
  const SceneDiagnosis scene = DiagnoseScene(arms, 1);
  EXPECT_EQ(scene.leader, 2u);
  EXPECT_TRUE(scene.arms[0].is_outdated);
  EXPECT_FALSE(scene.arms[0].best_probability);
  EXPECT_FALSE(scene.arms[1].is_outdated);
  EXPECT_NEAR(*scene.arms[1].best_probability + *scene.arms[2].best_probability, 1, 1e-9);
}

TEST(SceneDiagnosis, IsUnknownWithoutEvidenceOrWithOnlyOneArm) {
  for (const uint32_t version : {1u, kLogCostRewardVersion}) {
    const std::vector<SceneArm> flat = {{"SAP", 1, {}}, {"Grid", 1, {}}};
    EXPECT_EQ(DiagnoseScene(flat, version).verdict, Verdict::kUnknown);
    EXPECT_FALSE(DiagnoseScene(flat, version).leader);
    const std::vector<SceneArm> only = {{"SAP", 1, {9, 5}}, {"SAP", 2, {500, 2}}};
    const SceneDiagnosis scene = DiagnoseScene(only, version);
    EXPECT_EQ(scene.verdict, Verdict::kUnknown);
    EXPECT_FALSE(scene.arms[1].best_probability);
    EXPECT_TRUE(DiagnoseScene({}, version).arms.empty());
  }
}

}  // namespace
}  // namespace sweepstake::decision
