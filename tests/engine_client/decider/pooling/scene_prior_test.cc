#include "engine_client/decider/pooling/scene_prior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine_client/decider/policy/log_cost.h"
#include "tests/engine_client/decider/pooling/evidence_sums.h"

namespace sweepstake::decision {
namespace {

constexpr double kNoise = 0.02 * 0.02;

TEST(ScenePrior, EqualsTheWindowsIfTheLaneWasOff) {
  const ArmEvidence arms[] = {{.live = {7, 3}}, {.live = {2, 8}, .bail_out_count = 1}, {}};
  const auto pooled = PoolEvidence(arms);
  EXPECT_EQ(pooled[0].alpha, 7);
  EXPECT_EQ(pooled[1].beta, 8);
  EXPECT_EQ(pooled[2].evidence(), 0);
}

TEST(ScenePrior, IncludesArmsThatWereNeverLive) {
  const ArmEvidence arms[] = {{.live = SumOf(100, 50), .lane = SumOf(100, 10)},
                              {.lane = SumOf(150, 10)},
                              {.lane = SumOf(80, 10)}};
  const auto pooled = PoolEvidence(arms);
  EXPECT_NEAR(CostUs(pooled[0]), 100, 0.1);
  EXPECT_NEAR(CostUs(pooled[1]), 150, 0.2);
  EXPECT_NEAR(CostUs(pooled[2]), 80, 0.1);
}

// The first arm ran while the scene was empty, the second arm while the scene was full. In the
// lane's visits, which compare both at the same time, the second arm costs half as much.
TEST(ScenePrior, ComparesWindowsOfDifferentTimesByTheVisits) {
  const ArmEvidence arms[] = {{.live = SumOf(20, 50), .lane = SumOf(200, 10)},
                              {.live = SumOf(500, 50), .lane = SumOf(100, 10)}};
  const auto pooled = PoolEvidence(arms);
  EXPECT_NEAR(CostUs(pooled[0]) / CostUs(pooled[1]), 2, 0.01);
}

TEST(ScenePrior, MovesVisitsToTheLevelOfTheWindows) {
  const ArmEvidence arms[] = {{.live = SumOf(100, 50), .lane = SumOf(130, 10)},
                              {.lane = SumOf(260, 10)},
                              {.live = SumOf(70, 5)}};  // too little memory in the lane
  const auto pooled = PoolEvidence(arms);
  EXPECT_NEAR(CostUs(pooled[0]), 100, 0.1);
  EXPECT_NEAR(CostUs(pooled[1]), 200, 0.3);
  EXPECT_NEAR(CostUs(pooled[2]), 70, 0.1);
}

TEST(ScenePrior, LimitsThePrecisionOfVisitsByTheLanesBias) {
  const ArmEvidence arms[] = {{.live = SumOf(100, 50), .lane = SumOf(100, 1e6)},
                              {.lane = SumOf(100, 1)},
                              {.lane = SumOf(100, 1e6)},
                              {.live = SumOf(100, 1), .lane = SumOf(100, 1e6)}};
  const auto pooled = PoolEvidence(arms);
  EXPECT_LT(DeviationOf(pooled[0]), 0.004) << "from its windows alone";
  EXPECT_NEAR(DeviationOf(pooled[1]), std::sqrt(kLaneBiasVariance + kNoise), 0.001);
  EXPECT_NEAR(DeviationOf(pooled[2]), std::sqrt(kLaneBiasVariance), 0.001);
  EXPECT_GT(DeviationOf(pooled[3]), 0.015) << "one window does not make the visits precise";
}

TEST(ScenePrior, IncludesABailOutThatTheLaneDoesNotShow) {
  EvidenceSum stalled = SumOf(100, 5);
  stalled.beta += stalled.evidence() * 2;
  const ArmEvidence arms[] = {{.live = SumOf(100, 50), .lane = SumOf(100, 10)},
                              {.live = stalled, .lane = SumOf(90, 10), .bail_out_count = 1}};
  const auto pooled = PoolEvidence(arms);
  EXPECT_NEAR(CostUs(pooled[0]), 100, 0.1) << "the stall does not change its level";
  EXPECT_GT(CostUs(pooled[1]), 1e4);
}

std::vector<EvidenceSum> SceneOf(std::initializer_list<double> costs_us) {
  std::vector<EvidenceSum> scene;
  for (const double cost : costs_us) scene.push_back(cost > 0 ? SumOf(cost, 1000) : EvidenceSum());
  return scene;
}

// Returns the prior of a scene without its own evidence.
std::vector<EvidenceSum> PriorOfNewScene(std::span<const std::vector<EvidenceSum>> others) {
  return WithOtherScenes(std::vector<EvidenceSum>(others.front().size()), others);
}

TEST(PriorOfNewScene, IsTheMeanCostRelativeToTheOtherArms) {
  const std::vector<EvidenceSum> scenes[] = {SceneOf({100, 200, 400}), SceneOf({1000, 2000, 4000})};
  const auto prior = PriorOfNewScene(scenes);
  EXPECT_NEAR(CostUs(prior[1]) / CostUs(prior[0]), 2, 0.01);
  EXPECT_NEAR(CostUs(prior[2]) / CostUs(prior[0]), 4, 0.02);
  EXPECT_NEAR(DeviationOf(prior[0]), 0.3 * std::sqrt(1.5), 0.01) << "the deviation of two scenes";
}

TEST(PriorOfNewScene, IsWiderIfTheScenesDiffer) {
  const std::vector<EvidenceSum> alike[] = {SceneOf({100, 200}), SceneOf({100, 210})};
  const std::vector<EvidenceSum> unlike[] = {SceneOf({100, 200}), SceneOf({100, 20})};
  EXPECT_GT(DeviationOf(PriorOfNewScene(unlike)[1]), 2 * DeviationOf(PriorOfNewScene(alike)[1]));
}

TEST(WithOtherScenes, FillsInMissingArmsAtTheScenesOwnLevel) {
  const std::vector<EvidenceSum> others[] = {SceneOf({100, 200, 400}), SceneOf({1000, 2000, 4000})};
  const auto filled = WithOtherScenes(SceneOf({0, 50, 0}), others);
  EXPECT_NEAR(CostUs(filled[0]), 25, 0.5);
  EXPECT_NEAR(CostUs(filled[1]), 50, 0.1);
  EXPECT_NEAR(CostUs(filled[2]), 100, 2);
  EXPECT_NEAR(CostUs(WithOtherScenes(SceneOf({7, 8, 9}), others)[2]), 9, 0.1);
  EXPECT_EQ(WithOtherScenes(SceneOf({0, 50, 0}), {})[0].evidence(), 0);
}

TEST(PriorOfNewScene, OmitsArmsThatCannotBeCompared) {
  const std::vector<EvidenceSum> scenes[] = {SceneOf({100, 200, 0}), SceneOf({0, 9, 0})};
  const auto prior = PriorOfNewScene(scenes);
  EXPECT_NEAR(CostUs(prior[1]) / CostUs(prior[0]), 2, 0.01) << "the second scene has only one arm";
  EXPECT_EQ(prior[2].evidence(), 0);
}

}  // namespace
}  // namespace sweepstake::decision
