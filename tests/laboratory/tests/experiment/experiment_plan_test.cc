// Tests the plan of an experiment: the grid, seeds and policies that result from the options.
#include "tests/laboratory/experiment/experiment_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "engine_client/decider/embedded/study_maker.h"
#include "sweepstake/broad_phase.h"
#include "tests/laboratory/experiment/experiment_run.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/laboratory/tests/lab_command.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::PlanOf;
using test_support::TemporaryDirectory;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

template <typename Labelled>
std::vector<std::string> Labels(const std::vector<Labelled>& items) {
  std::vector<std::string> labels;
  for (const Labelled& item : items) labels.push_back(item.label());
  return labels;
}

// Returns options with two scenes of 60 objects, two policies and two runs.
ExperimentOptions SmallOptions() {
  ExperimentOptions options;
  options.scenes = {"hurricane", "brownian"};
  options.object_counts = {60};
  options.policies = {"paper", "random"};
  options.run_count = 2;
  return options;
}

TEST(ExperimentPlan, IsThePapersGridAndTwoSizesBeyond) {
  const ExperimentPlan plan = PlanOf({});
  EXPECT_EQ(plan.cells.size(), 15U);
  EXPECT_EQ(plan.runs.size(), 15U * 2 * 5);
  EXPECT_EQ(plan.window_ns, 900'000'000'000U);
  ExperimentOptions options;
  options.object_counts = {2000};
  EXPECT_EQ(PlanOf(options).cells.size(), 3U);
  options.quick = true;
  EXPECT_EQ(PlanOf(options).runs.size(), 6U);
}

TEST(ExperimentPlan, HasAGridInWhichTheFastestArmChanges) {
  ExperimentOptions options;
  options.grid = "crossovers";
  options.quick = true;
  const ExperimentPlan quick = PlanOf(options);
  EXPECT_EQ(quick.cells.size(), 12U);
  EXPECT_EQ(quick.options.trace_frame_count, 800U) << "two regimes of storms";
  options.quick = false;
  options.scenes = {"storms"};
  options.run_count = 1;
  EXPECT_THAT(Labels(PlanOf(options).cells),
              ElementsAre("storms-1000", "storms-10000", "storms-100000"));
}

TEST(ExperimentPlan, HoldsEveryCellOfThePapersTables) {
  const ExperimentPlan plan = PlanOf({});
  for (const PaperCell& paper : PaperCells()) {
    const bool is_planned =
        std::any_of(plan.cells.begin(), plan.cells.end(), [&](const ExperimentCell& cell) {
          return cell.scene == paper.scene && cell.object_count == paper.object_count;
        });
    EXPECT_TRUE(is_planned) << paper.scene << ' ' << paper.object_count;
  }
  EXPECT_EQ(plan.options.run_count, kPaperRunCount);
}

TEST(ExperimentPlan, QuickIsSixCellsWithOneRunOfEachPolicy) {
  ExperimentOptions options;
  options.quick = true;
  const ExperimentPlan plan = PlanOf(options);
  EXPECT_THAT(Labels(plan.cells),
              ElementsAre("brownian-1000", "brownian-3000", "rotating-gravity-1000",
                          "rotating-gravity-3000", "hurricane-1000", "hurricane-3000"));
  EXPECT_EQ(plan.runs.size(), 12U);
  EXPECT_EQ(plan.options.trace_frame_count, 240U);
  EXPECT_EQ(plan.options.replay_seed_count, 10U);
  options.run_count = 3;
  options.trace_frame_count = 64;
  EXPECT_EQ(PlanOf(options).runs.size(), 36U) << "explicit options are kept";
  EXPECT_EQ(PlanOf(options).options.trace_frame_count, 64U);
}

TEST(ExperimentPlan, RunsByCellThenNumberThenPolicy) {
  EXPECT_THAT(Labels(PlanOf(SmallOptions()).runs),
              ElementsAre("hurricane-60-paper-1", "hurricane-60-random-1", "hurricane-60-paper-2",
                          "hurricane-60-random-2", "brownian-60-paper-1", "brownian-60-random-1",
                          "brownian-60-paper-2", "brownian-60-random-2"));
}

TEST(ExperimentPlan, KeepsTheOrderOfTheCountsAndRejectsACellTwice) {
  ExperimentOptions options = SmallOptions();
  options.scenes = {"brownian"};
  options.object_counts = {80, 60};
  EXPECT_THAT(Labels(PlanOf(options).cells), ElementsAre("brownian-80", "brownian-60"));
  options.object_counts = {60, 60};
  EXPECT_THAT(MakePlan(options).status().message(), HasSubstr("two cells are called brownian-60"));
}

TEST(ExperimentPlan, DividesTheWindowByTheTimeScale) {
  ExperimentOptions options;
  options.time_scale = 60;
  const ExperimentPlan plan = PlanOf(options);
  EXPECT_EQ(plan.window_ns, 15'000'000'000U);
  options.window = "30m";
  EXPECT_EQ(PlanOf(options).window_ns, 30'000'000'000U);
}

TEST(ExperimentPlan, GivesEachRunOfACellItsOwnSeedAndPoliciesTheSame) {
  const ExperimentPlan plan = PlanOf({});
  std::set<uint64_t> seeds;
  for (size_t i = 0; i < plan.runs.size(); i += 2) {
    EXPECT_EQ(plan.runs[i].seed, plan.runs[i + 1].seed);
    EXPECT_EQ(plan.runs[i].initial_arm, plan.runs[i + 1].initial_arm);
    EXPECT_NE(plan.runs[i].policy, plan.runs[i + 1].policy);
    seeds.insert(plan.runs[i].seed);
  }
  EXPECT_EQ(seeds.size(), plan.runs.size() / 2);
}

TEST(ExperimentPlan, GivesEachRunOfACellItsOwnSceneAndPoliciesTheSame) {
  const ExperimentPlan plan = PlanOf(SmallOptions());
  ASSERT_THAT(Labels(plan.scenes),
              ElementsAre("hurricane-60-1", "hurricane-60-2", "brownian-60-1", "brownian-60-2"));
  std::set<uint64_t> seeds;
  for (size_t i = 0; i < plan.runs.size(); i += 2) {
    EXPECT_EQ(plan.runs[i].scene_seed, plan.runs[i + 1].scene_seed);
    EXPECT_EQ(plan.runs[i].scene_seed, plan.scenes[i / 2].seed);
    EXPECT_NE(plan.runs[i].scene_seed, plan.runs[i].seed) << "scene and decisions are independent";
    seeds.insert(plan.runs[i].scene_seed);
  }
  EXPECT_EQ(seeds.size(), plan.runs.size() / 2);
}

// The boxes of this scene are the same with every seed.
TEST(ExperimentPlan, HasOneSceneIfTheSeedDoesNotMatter) {
  ExperimentOptions options = SmallOptions();
  options.scenes = {"suite-b"};
  const ExperimentPlan plan = PlanOf(options);
  ASSERT_THAT(Labels(plan.scenes), ElementsAre("suite-b-60-1"));
  for (const PlannedRun& run : plan.runs) EXPECT_EQ(run.scene_seed, plan.scenes[0].seed);
  EXPECT_NE(plan.runs[0].seed, plan.runs[2].seed);
}

TEST(ExperimentPlan, SeedsAreOddAndEveryReaderOfJsonKeepsThem) {
  ExperimentOptions options = SmallOptions();
  options.seed = ~uint64_t{0};
  const ExperimentPlan plan = PlanOf(options);
  for (const PlannedRun& run : plan.runs) {
    EXPECT_LT(run.seed, uint64_t{1} << 53) << run.label();
    EXPECT_EQ(run.seed % 2, 1U) << run.label();
    EXPECT_LT(run.scene_seed, uint64_t{1} << 53) << run.label();
  }
  options.seed = 7;
  EXPECT_NE(PlanOf(options).runs[0].seed, plan.runs[0].seed);
  EXPECT_NE(PlanOf(options).runs[0].scene_seed, plan.runs[0].scene_seed);
}

TEST(ExperimentPlan, KeepsTheSeedsOfACellInAnotherGrid) {
  ExperimentOptions options;
  options.scenes = {"hurricane"};
  options.object_counts = {3000};
  const PlannedRun alone = PlanOf(options).runs[0];
  size_t found = 0;
  for (const PlannedRun& run : PlanOf({}).runs) {
    if (run.label() != alone.label()) continue;
    ++found;
    EXPECT_EQ(run, alone);
  }
  EXPECT_EQ(found, 1U);
}

TEST(ExperimentPlan, TheInitialArmRotatesOverTheRuns) {
  ExperimentOptions options = SmallOptions();
  options.scenes = {"brownian"};
  options.policies = {"paper"};
  options.run_count = 9;
  const auto arms = static_cast<uint32_t>(BroadPhaseNames().size());
  ASSERT_EQ(arms, 7U);
  const ExperimentPlan plan = PlanOf(options);
  for (uint32_t run = 0; run < 9; ++run) EXPECT_EQ(plan.runs[run].initial_arm, run % arms) << run;
}

TEST(ExperimentPlan, ARecordingIsACellWithItsOwnCountOfObjects) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "level.aabbs").string();
  ASSERT_EQ(
      RunLabCommand("record --scene brownian --objects 50 --frames 3 --out " + file).exit_code, 0);
  ExperimentOptions options = SmallOptions();
  options.scenes = {file};
  options.object_counts = {60, 80};
  const ExperimentPlan plan = PlanOf(options);
  ASSERT_THAT(Labels(plan.cells), ElementsAre("level-50"));
  EXPECT_EQ(plan.cells[0].scene, file);
  EXPECT_EQ(plan.scenes.size(), 1U) << "a recording is the same in every run";
  EXPECT_EQ(plan.runs[1].label(), "level-50-random-1");
}

TEST(ExperimentPlan, NamesWhatThereIsNot) {
  const auto message = [](const auto& change) {
    ExperimentOptions options;
    change(options);
    return MakePlan(options).status().message();
  };
  EXPECT_THAT(message([](auto& o) { o.policies = {"papre"}; }),
              HasSubstr("unknown policy 'papre', must be one of paper, default, "));
  EXPECT_THAT(message([](auto& o) { o.policies = {"paper", "paper"}; }), HasSubstr("twice"));
  EXPECT_THAT(message([](auto& o) { o.window = "long"; }), HasSubstr("60s"));
  EXPECT_THAT(message([](auto& o) { o.other_work = "much"; }), HasSubstr("60s"));
  EXPECT_THAT(message([](auto& o) { o.decision.weights.fps = 0.5; }),
              HasSubstr("make them sum to 1"));
  EXPECT_THAT(message([](auto& o) { o.scenes = {"nowhere"}; }), HasSubstr("hurricane"));
  EXPECT_THAT(message([](auto& o) {
                o.scenes = {"hurricane", "hurricane"};
              }),
              HasSubstr("hurricane-1000"));
}

// Ablations of AI Decides are available only in experiments.
TEST(ExperimentPlan, AcceptsEveryAblation) {
  ExperimentOptions options = SmallOptions();
  options.policies = {"adaptive"};
  for (const decision::PolicyEntry& entry : decision::StudyPolicies()) {
    const std::string_view name = entry.kind.name;
    if (name.starts_with("adaptive-without-")) options.policies.emplace_back(name);
  }
  EXPECT_EQ(PlanOf(options).options.policies.size(), 8U);
  options.policies = {"adaptive-without-gates"};
  EXPECT_THAT(MakePlan(options).status().message(), HasSubstr("one of adaptive-without-gate,"));
}

// With the weight of the checks alone, the arm's reward is the share of pairs that it did not
// check.
TEST(StudyMaker, UsesTheRewardWeights) {
  const auto reward = [](const RewardWeights& weights) {
    EmbeddedOptions options;
    options.policy = "random";
    options.weights = weights;
    const std::vector<std::string> arms = {"SAP"};
    const std::vector<uint32_t> versions = {1};
    const StudyMaker maker{decision::StudyPolicies()};
    const auto decider = maker.MakeDecider(options, arms, versions, 0);
    EXPECT_TRUE(decider.ok()) << decider.status().message();
    FrameSample frame{.frame_time_ns = 10'000'000, .object_count = 5};
    frame.aabb_check_count = 5;  // of 10 pairs
    uint64_t now_ns = 0;
    for (int i = 0; i < 500; ++i) {
      now_ns += frame.frame_time_ns;
      frame.frame_index = static_cast<uint64_t>(i);
      (*decider)->Observe({&frame, 1}, now_ns);
      (*decider)->Poll(now_ns);
    }
    return (*decider)->last_decision()->reward;
  };
  EXPECT_EQ(reward({.fps = 0, .detection = 0, .memory = 0, .checks = 1}), 0.5);
  EXPECT_EQ(reward({.fps = 0, .detection = 0, .memory = 1, .checks = 0}), 1);
}

TEST(StudyMaker, MakesADeciderForAnAblationThatAGameCannotChoose) {
  EmbeddedOptions options;
  options.policy = "adaptive-without-gate";
  const std::vector<std::string> arms = {"SAP", "Grid"};
  const std::vector<uint32_t> versions = {1, 1};
  const StudyMaker maker{decision::StudyPolicies()};
  EXPECT_TRUE(maker.MakeDecider(options, arms, versions, 0).ok());
  EXPECT_EQ(EmbeddedDecider::Create(options, arms, versions, 0).status().code(),
            StatusCode::kInvalidArgument);
  options.policy = "adaptive-without-luck";
  EXPECT_THAT(maker.MakeDecider(options, arms, versions, 0).status().message(),
              AllOf(HasSubstr("unknown policy"), HasSubstr("adaptive-without-gate")));
}

TEST(PlayLive, StartsARunOfAnAblationAndEndsItWhenItMayNotGoOn) {
  ExperimentOptions options = SmallOptions();
  options.scenes = {"brownian"};
  options.policies = {"adaptive-without-shadow"};
  const ExperimentPlan plan = PlanOf(options);
  int asked_count = 0;
  const auto record =
      PlayLive(plan.runs[0], {.window_ns = 1'000'000, .time_scale = 1000, .go_on = [&](uint64_t) {
                                ++asked_count;
                                return false;
                              }});
  ASSERT_TRUE(record.ok()) << record.status().message();
  EXPECT_FALSE(*record) << "an unfinished run has no record";
  EXPECT_EQ(asked_count, 1);
}

}  // namespace
}  // namespace sweepstake::cli
