#include "engine_client/decider/options.h"
#include "engine_client/decider/session/policy_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine_client/decider/session/decision_session.h"
#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

using testing::HasSubstr;

TEST(Options, DefaultsAreValidAndThoseOfThePaper) {
  const DecisionOptions options;
  EXPECT_EQ(Validate(options, ShippedPolicies()), std::nullopt);
  EXPECT_EQ(options.decision_interval_ns, 2 * kSecond);
  EXPECT_EQ(options.cooldown_ns, 40 * kSecond);
  EXPECT_EQ(options.settling_ns, 2 * kSecond);
  EXPECT_EQ(options.bail_out_ns, 5 * kSecond);
  EXPECT_EQ(options.bail_out_penalty, 10);
}

TEST(Options, WithRulesKeepTheOthers) {
  DecisionOptions options;
  options.cooldown_ns = 7;
  EXPECT_EQ(options.With({}).cooldown_ns, 7);
  const DecisionOptions changed = options.With({.weights = RewardWeights{0, 1, 0, 0},
                                                .decision_interval_ns = 3,
                                                .cooldown_ns = 0,
                                                .settling_ns = 5});
  EXPECT_EQ(changed.weights, (RewardWeights{0, 1, 0, 0}));
  EXPECT_EQ(changed.decision_interval_ns, 3);
  EXPECT_EQ(changed.cooldown_ns, 0);
  EXPECT_EQ(changed.settling_ns, 5);
  EXPECT_THAT(NumberProblems(options.With({.settling_ns = UINT64_MAX})),
              testing::ElementsAre(HasSubstr("settling_ns")));
}

TEST(RewardVersion, OfOwnWeightsIsTheirOwn) {
  const PolicyKind& paper = PolicyKindOf("paper", ShippedPolicies());
  const PolicyKind& adaptive = PolicyKindOf("adaptive", ShippedPolicies());
  const RewardWeights own = {0.25, 0.25, 0.5, 0};
  EXPECT_EQ(RewardVersionOf(paper, {}), 1u);
  EXPECT_EQ(RewardVersionOf(paper, own), 1'941'152'689u) << "stores have it on their disks";
  EXPECT_EQ(RewardVersionOf(paper, {0.25, 0.25, 0.5, -0.0}), RewardVersionOf(paper, own));
  EXPECT_NE(RewardVersionOf(paper, {0.25, 0.5, 0.25, 0}), RewardVersionOf(paper, own));
  EXPECT_GE(RewardVersionOf(paper, {0, 0, 0, 1}), kFirstOwnRewardVersion);
  EXPECT_LT(RewardVersionOf(paper, {0, 0, 0, 1}), 2 * kFirstOwnRewardVersion);
  EXPECT_EQ(RewardVersionOf(adaptive, own), 3u) << "its reward does not depend on the weights";
}

TEST(Options, TheDefaultPolicyIsThatOfAiDecides) {
  EXPECT_EQ(DecisionOptions().policy, "default");
  EXPECT_EQ(PolicyKindOf("default", ShippedPolicies()).name, "adaptive");
}

TEST(Options, UnknownPolicyListsTheValidOnes) {
  DecisionOptions options;
  options.policy = "papre";
  ASSERT_TRUE(Validate(options, ShippedPolicies()));
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("papre"));
  for (const std::string_view name : PolicyNames(ShippedPolicies()))
    EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr(std::string(name)));
}

TEST(Options, AnAblationIsUnknownOutsideTheLaboratory) {
  size_t ablation_count = 0;
  for (const PolicyEntry& entry : StudyPolicies()) {
    if (!entry.kind.name.starts_with("adaptive-without-")) continue;
    ++ablation_count;
    DecisionOptions options;
    options.policy = entry.kind.name;
    ASSERT_TRUE(Validate(options, ShippedPolicies())) << entry.kind.name;
    EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("unknown policy"));
    EXPECT_EQ(Validate(options, StudyPolicies()), std::nullopt);
  }
  EXPECT_EQ(ablation_count, 7u);
}

TEST(Options, AGameChoosesBetweenAiDecidesAndThePapersPolicy) {
  EXPECT_THAT(PolicyNames(ShippedPolicies()), testing::ElementsAre("default", "adaptive", "paper"));
}

TEST(Options, TheLaboratoryHasEveryShippedPolicy) {
  EXPECT_EQ(PolicyNames(StudyPolicies()).size(), PolicyNames(ComparedPolicies()).size() + 7);
  for (const std::string_view name : PolicyNames(ShippedPolicies()))
    EXPECT_NE(FindPolicy(name, StudyPolicies()), nullptr) << name;
}

TEST(Options, WeightsMustSumToOne) {
  DecisionOptions options;
  options.weights.fps = 0.56;
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("sum to 1"));
  options.weights = {.fps = 0.25, .detection = 0.25, .memory = 0.25, .checks = 0.25};
  EXPECT_EQ(Validate(options, ShippedPolicies()), std::nullopt);
  options.weights = {.fps = 1.5, .detection = -0.5, .memory = 0, .checks = 0};
  EXPECT_TRUE(Validate(options, ShippedPolicies()));
  options.weights.fps = std::nan("");
  EXPECT_TRUE(Validate(options, ShippedPolicies()));
}

TEST(Options, IntervalsOutOfRangeAreNamed) {
  DecisionOptions options;
  options.decision_interval_ns = 0;
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("decision_interval_ns"));
  options = {};
  options.cooldown_ns = -1;
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("cooldown_ns"));
  options = {};
  options.bail_out_ns = std::numeric_limits<int64_t>::max();
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("bail_out_ns"));
  options = {};
  options.exploration_measure_ns = 0;
  EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("exploration_measure_ns"));
}

TEST(Options, BailOutPenaltyIsFiniteAndNotNegative) {
  for (const double penalty : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    DecisionOptions options;
    options.bail_out_penalty = penalty;
    EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("bail_out_penalty"));
  }
}

TEST(Options, FrameRateFloorIsFiniteAndNotNegative) {
  EXPECT_EQ(DecisionOptions().fps_floor, 30);
  for (const double floor : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    DecisionOptions options;
    options.fps_floor = floor;
    EXPECT_THAT(*Validate(options, ShippedPolicies()), HasSubstr("fps_floor"));
  }
}

TEST(TimeScale, DividesEveryIntervalExceptTheBailOutLimit) {
  const DecisionOptions scaled = DecisionOptions().Scaled(100);
  EXPECT_EQ(scaled.decision_interval_ns, 20 * kMillisecond);
  EXPECT_EQ(scaled.cooldown_ns, 400 * kMillisecond);
  EXPECT_EQ(scaled.settling_ns, 20 * kMillisecond);
  EXPECT_EQ(scaled.exploration_warm_up_ns, 20 * kMillisecond);
  EXPECT_EQ(scaled.exploration_measure_ns, 40 * kMillisecond);
  EXPECT_EQ(scaled.bail_out_ns, 5 * kSecond);
}

TEST(TimeScale, NeverMakesANonzeroIntervalZero) {
  DecisionOptions options;
  options.decision_interval_ns = 1;
  options.cooldown_ns = 0;
  EXPECT_EQ(options.Scaled(1000).decision_interval_ns, 1);
  EXPECT_EQ(options.Scaled(1000).cooldown_ns, 0);
}

TEST(Setup, AcceptsOneToThirtyTwoUniqueArms) {
  EXPECT_TRUE(Validate(PlainSetup(0), ShippedPolicies()));
  EXPECT_EQ(Validate(PlainSetup(1), ShippedPolicies()), std::nullopt);
  EXPECT_EQ(Validate(PlainSetup(32), ShippedPolicies()), std::nullopt);
  EXPECT_TRUE(Validate(PlainSetup(33), ShippedPolicies()));
  SessionSetup setup = PlainSetup(2);
  setup.arms[1] = setup.arms[0];
  EXPECT_THAT(*Validate(setup, ShippedPolicies()), HasSubstr("arm0"));
  setup.arms[1].clear();
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
}

TEST(Setup, IndicesMustBeWithinTheArms) {
  SessionSetup setup = PlainSetup(2);
  setup.active_arm = 2;
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  setup.active_arm = 0;
  setup.initial_arm = 2;
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  setup.initial_arm = 0;
  setup.explored_arm_count = 3;
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
}

TEST(Priors, MustBePositiveFiniteAndOnePerArm) {
  SessionSetup setup = PlainSetup(2);
  setup.priors = {{1, 1}};
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  for (const double bad :
       {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e15}) {
    setup.priors = {{1, 1}, {bad, 1}};
    EXPECT_THAT(*Validate(setup, ShippedPolicies()), HasSubstr("arm1"));
    setup.priors = {{1, 1}, {1, bad}};
    EXPECT_THAT(*Validate(setup, ShippedPolicies()), HasSubstr("arm1"));
  }
}

TEST(Setup, ModeIsManualOrAi) {
  SessionSetup setup = PlainSetup(2);
  setup.mode = static_cast<Mode>(0);
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
}

}  // namespace
}  // namespace sweepstake::decision
