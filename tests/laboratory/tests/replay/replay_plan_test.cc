// Tests the plan that `sweepstake-lab replay` makes from its options.
#include "tests/laboratory/replay/replay_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/tests/replay/replay_fixtures.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

class ReplayPlanTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, const SyntheticTrace& trace) {
    const auto path = folder_.path() / name;
    EXPECT_TRUE(WriteCosts(path, MakeTrace(trace)).ok());
    return path.string();
  }
  ReplayRequest Request() {
    ReplayRequest request;
    request.costs = {Write("a.costs", TwiceAsSlow()), Write("b.costs", TwiceAsSlow())};
    request.policies = {"paper", "fixed"};
    return request;
  }
  static std::string Problem(const ReplayRequest& request) {
    const auto plan = MakeReplayPlan(request);
    EXPECT_FALSE(plan.ok());
    return plan.status().message();
  }

 private:
  test_support::TemporaryDirectory folder_;
};

TEST_F(ReplayPlanTest, HasASceneForEachTraceAndAPlayerForEachWord) {
  ReplayRequest request = Request();
  request.study.seed_count = 7;
  request.run = "2m";
  const auto plan = MakeReplayPlan(request);
  ASSERT_TRUE(plan.ok()) << plan.status().message();
  ASSERT_EQ(plan->scenes.size(), 2U);
  EXPECT_EQ(plan->scenes[1].name, request.costs[1]);
  EXPECT_EQ(plan->scenes[0].scene.frame_count(), 12'000U);
  ASSERT_EQ(plan->study.players.size(), 3U);
  EXPECT_EQ(plan->study.players[2].name, "fixed:KDTree");
  EXPECT_EQ(plan->study.players[2].arm, 1U);
  EXPECT_EQ(plan->study.seed_count, 7U);
  EXPECT_EQ(plan->study.priors, ReplayPriors::kNone);
  EXPECT_FALSE(plan->study.shadow_lane) << "the policy decides whether there is a lane";
}

TEST_F(ReplayPlanTest, ThePassIsTheRunsOrOneForAllTracesOrEachTracesOwn) {
  const auto passes = [&](std::vector<std::string> words) {
    ReplayRequest request = Request();
    request.run = "3m";
    request.passes = std::move(words);
    const auto plan = MakeReplayPlan(request);
    std::vector<uint64_t> seconds;
    for (const StudyScene& each : plan->scenes) {
      seconds.push_back(each.scene.options().pass_ns / 1'000'000'000);
    }
    return seconds;
  };
  EXPECT_THAT(passes({}), testing::ElementsAre(180U, 180U));
  EXPECT_THAT(passes({"90s"}), testing::ElementsAre(90U, 90U));
  EXPECT_THAT(passes({"90s", "1m"}), testing::ElementsAre(90U, 60U));
}

TEST_F(ReplayPlanTest, ChecksTheNumbersOfTheDecider) {
  ReplayRequest request = Request();
  request.study.decision.cooldown_ns = 8'000'000'000;
  const auto plan = MakeReplayPlan(request);
  ASSERT_TRUE(plan.ok()) << plan.status().message();
  EXPECT_EQ(plan->study.decision.cooldown_ns, 8'000'000'000);
  request.study.decision.weights.fps = 1;
  EXPECT_THAT(Problem(request), HasSubstr("make them sum to 1"));
}

TEST_F(ReplayPlanTest, PriorsAndTheLaneAreWhatTheWordsSay) {
  ReplayRequest request = Request();
  request.priors = "wrong";
  request.no_shadow = true;
  const auto plan = MakeReplayPlan(request);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->study.priors, ReplayPriors::kWrong);
  EXPECT_EQ(plan->study.shadow_lane, false);
}

TEST_F(ReplayPlanTest, NamesTheWordThatIsWrong) {
  const auto with = [&](auto ReplayRequest::*field, auto value) {
    ReplayRequest request = Request();
    request.*field = value;
    return Problem(request);
  };
  EXPECT_THAT(with(&ReplayRequest::run, "soon"), HasSubstr("'soon' is not a duration"));
  EXPECT_THAT(with(&ReplayRequest::run, "1ms"), HasSubstr("a.costs: the run is shorter"));
  EXPECT_THAT(with(&ReplayRequest::passes, std::vector<std::string>{"1m", "2m", "3m"}),
              HasSubstr("3 durations for 2 traces"));
  EXPECT_THAT(with(&ReplayRequest::policies, std::vector<std::string>{"pape"}),
              HasSubstr("unknown policy 'pape', must be one of paper, default, "));
}

TEST_F(ReplayPlanTest, TheLaneMisjudgesTheArmsThatAreNamed) {
  ReplayRequest request = Request();
  request.study.lane_errors.noise_deviation = 0.15;
  auto plan = MakeReplayPlan(request);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->study.lane_errors.noise_deviation, 0.15);
  EXPECT_TRUE(plan->study.lane_errors.arm_ratios.empty());
  request.lane_ratios = {{"KDTree", "0.9"}};
  plan = MakeReplayPlan(request);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->study.lane_errors.arm_ratios, (std::vector<double>{1, 0.9}));
  request.lane_ratios = {{"KDTre", "0.9"}};
  EXPECT_THAT(Problem(request), HasSubstr("KDTree"));
  for (const char* wrong : {"0", "101", "fast", "1x", "", "nan"}) {
    request.lane_ratios = {{"KDTree", wrong}};
    EXPECT_THAT(Problem(request), HasSubstr("0.01 to 100"));
  }
}

TEST_F(ReplayPlanTest, TracesHaveToHaveTheSameArms) {
  ReplayRequest request = Request();
  SyntheticTrace other = TwiceAsSlow();
  other.arms = {"SAP", "Grid"};
  request.costs[1] = Write("other.costs", other);
  EXPECT_THAT(Problem(request), HasSubstr("other.costs has the arms SAP, Grid, but "));
  request.costs[1] = "/nonexistent.costs";
  EXPECT_THAT(Problem(request), HasSubstr("/nonexistent.costs"));
}

TEST(ReplayPlayers, SayWhatIsValid) {
  const std::vector<std::string> arms = {"Grid", "SAP"};
  const auto message = [&](std::vector<std::string> words) {
    return ReplayPlayers(words, arms).status().message();
  };
  EXPECT_THAT(message({"pape"}), HasSubstr("must be one of paper, default, "));
  EXPECT_THAT(message({"pape"}), HasSubstr("all, ablations, fixed, fixed:ARM, oracle"));
  EXPECT_THAT(message({"fixed:Octree"}), HasSubstr("unknown traced arm 'Octree', must be one of "));
  EXPECT_THAT(message({"fixed:Sap"}), testing::EndsWith("'Sap', must be one of SAP, Grid"));
  const auto players = ReplayPlayers(std::vector<std::string>{"fixed", "oracle", "paper"}, arms);
  ASSERT_EQ(players->size(), 4U);
  EXPECT_EQ((*players)[1].name, "fixed:SAP");
  EXPECT_EQ(ReplayPlayers(std::vector<std::string>{"all"}, arms)->size(),
            decision::PolicyNames(decision::StudyPolicies()).size() - 1);
  const auto ablations = ReplayPlayers(std::vector<std::string>{"ablations"}, arms);
  ASSERT_TRUE(ablations.ok());
  EXPECT_GT(ablations->size(), 1U);
  for (const ReplayPlayer& player : *ablations) {
    EXPECT_THAT(player.name, testing::StartsWith("adaptive-without-"));
  }
}

}  // namespace
}  // namespace sweepstake::cli
