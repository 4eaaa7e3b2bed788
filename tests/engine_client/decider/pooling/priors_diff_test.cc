#include "engine_client/decider/pooling/priors_diff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace sweepstake::decision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

PriorRecord RecordOf(const std::string& arm, double alpha, double beta,
                     const std::string& measured_by = "", uint32_t version = 1) {
  return {.key = {.project = "arcade",
                  .scene = "arena",
                  .measured_by = measured_by,
                  .arm = arm,
                  .backend_version = version,
                  .machine_class = "test",
                  .reward_version = 3},
          .source_id = "s",
          .source_sequence = 1,
          .evidence = {.alpha = alpha, .beta = beta}};
}

std::vector<PriorRecord> InScene(const std::string& scene, std::vector<PriorRecord> records) {
  for (PriorRecord& record : records) record.key.scene = scene;
  return records;
}

PriorsGroups Before() {
  std::vector<PriorRecord> records = {
      RecordOf("SAP", 620, 380), RecordOf("KDTree", 300, 200), RecordOf("SAP", 6000, 4000, "lane"),
      RecordOf("KDTree", 5600, 4400, "lane"), RecordOf("Grid", 5300, 4700, "lane")};
  const auto same = InScene("same", {RecordOf("SAP", 620, 380), RecordOf("Grid", 610, 390)});
  records.insert(records.end(), same.begin(), same.end());
  return GroupPriors(records);
}

PriorsGroups After() {
  std::vector<PriorRecord> records = {RecordOf("SAP", 610, 390),
                                      RecordOf("SAP", 100, 900),
                                      RecordOf("SAP", 6000, 4000, "lane", 2),
                                      RecordOf("SAP", 615, 385, "", 2),
                                      RecordOf("Grid", 640, 360),
                                      RecordOf("KDTree", 200, 300),
                                      RecordOf("KDTree", 5600, 4400, "lane"),
                                      RecordOf("Grid", 6100, 3900, "lane"),
                                      RecordOf("DBVT", 10, 90),
                                      RecordOf("Octree", 0, 0)};
  records[5].evidence.bail_out_count = 2;
  const auto same = InScene("same", {RecordOf("SAP", 620, 380), RecordOf("Grid", 611, 389)});
  const auto cave = InScene("cave", {RecordOf("SAP", 620, 380)});
  records.insert(records.end(), same.begin(), same.end());
  records.insert(records.end(), cave.begin(), cave.end());
  return GroupPriors(records);
}

double MedianOf(const std::optional<PriorsArm>& arm) {
  return arm && arm->cost_ratio ? arm->cost_ratio->median : 0;
}

TEST(PriorsDiff, FindsTheScenesInWhichAnArmsCostChanges) {
  const std::vector<SceneComparison> changes = DiffPriors(Before(), After());
  ASSERT_EQ(changes.size(), 2u);
  const SceneComparison& arena = changes[0];
  EXPECT_EQ(arena.key.scene, "arena");
  EXPECT_TRUE(arena.in_both());
  EXPECT_TRUE(arena.leader_changed());
  std::vector<std::string> names;
  for (const ArmComparison& arm : arena.arms) names.push_back(arm.arm);
  ASSERT_THAT(names, ElementsAre("DBVT", "Grid", "KDTree", "SAP")) << "Octree has no evidence";
  // Only the newest version of an arm counts. After a bail-out, its visits count at most the reward
  // of its windows.
  EXPECT_FALSE(arena.arms[0].before);
  EXPECT_NEAR(MedianOf(arena.arms[0].after), 146117.26256036034, 1e-6);
  EXPECT_NEAR(MedianOf(arena.arms[1].before), 4.774500028878618, 1e-8);
  EXPECT_EQ(MedianOf(arena.arms[1].after), 1);
  EXPECT_NEAR(MedianOf(arena.arms[2].before), 2.4431987649455724, 1e-8);
  EXPECT_NEAR(MedianOf(arena.arms[2].after), 179.89145149444013, 1e-8);
  EXPECT_EQ(MedianOf(arena.arms[3].before), 1);
  EXPECT_NEAR(MedianOf(arena.arms[3].after), 1.2502293787677672, 1e-8);
  EXPECT_NEAR(arena.arms[3].log_change(), std::log(1.2502293787677672), 1e-8);
  EXPECT_EQ(arena.arms[0].log_change(), 0) << "nothing is known before";
  const SceneComparison& cave = changes[1];
  EXPECT_EQ(cave.key.scene, "cave");
  EXPECT_FALSE(cave.in_both());
  EXPECT_FALSE(cave.leader_changed());
}

TEST(PriorsDiff, FindsNoneBetweenEqualEvidenceOrWithoutAny) {
  EXPECT_THAT(DiffPriors(Before(), Before()), IsEmpty());
  EXPECT_THAT(DiffPriors({}, {}), IsEmpty());
  EXPECT_EQ(ComparePriors(Before(), After()).size(), 3u) << "the unchanged scene too";
}

TEST(PriorsDiff, HasNoCostRatiosOfRewardsThatDoNotDependOnTheCostAlone) {
  PriorRecord record = RecordOf("SAP", 100, 500);
  record.key.reward_version = 1;
  PriorRecord better = record;
  better.evidence.alpha = 900;
  const PriorsGroups before = GroupPriors(std::vector{record});
  const PriorsGroups after = GroupPriors(std::vector{better});
  EXPECT_THAT(DiffPriors(before, after), IsEmpty());
  const std::vector<SceneComparison> scenes = ComparePriors(before, after);
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0].arms[0].after->pooled.alpha, 900);
  EXPECT_FALSE(scenes[0].arms[0].after->cost_ratio);
}

TEST(PriorsDiff, TheCheapestArmCostsExactlyOne) {
  const PriorsGroups groups =
      GroupPriors(std::vector{RecordOf("SAP", 62, 38), RecordOf("Grid", 61, 39)});
  const auto& arms = groups.begin()->second.arms;
  EXPECT_EQ(arms.at("SAP").cost_ratio->low, 1);
  EXPECT_EQ(arms.at("SAP").cost_ratio->high, 1);
  EXPECT_NEAR(arms.at("Grid").cost_ratio->median, std::exp(0.01 * std::log(5e9)), 1e-9);
}

}  // namespace
}  // namespace sweepstake::decision
