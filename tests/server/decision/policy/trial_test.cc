// The trials of "AI Decides": a game whose lane misjudges an arm, and that ends trials by itself as
// clients do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/adaptive/guards/trial_guard.h"
#include "server/decision/math/random.h"
#include "server/decision/policy/adaptive_policy.h"
#include "tests/server/decision/scripted_client.h"

namespace sweepstake::decision {
namespace {

// A trial lasts for two settling times, of which the policy reckons with what clients grant.
static_assert(AdaptivePolicy::kTrialBudget * TrialGuard::kBudgetShare == 2);

SessionSetup TrialSetup(uint32_t arm_count) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.policy = "adaptive";
  return setup;
}

// All of a frame is detection. What an arm costs, and what the lane says of it, may differ.
class TrialGame {
 public:
  TrialGame(std::vector<double> costs_us, std::vector<double> lane_costs_us)
      : client(TrialSetup(static_cast<uint32_t>(costs_us.size()))),
        cost_us(std::move(costs_us)),
        lane_cost_us(std::move(lane_costs_us)) {
    client.obedient = false;
  }

  void RunTicks(int count) {
    for (int i = 0; i < count; ++i) RunTick();
  }

  void RunTick() {
    Sweep();
    while (client.now_ns < client.session.next_tick_ns()) RunFrame();
    const size_t before = client.commands.size();
    client.RunToTick();
    if (client.commands.size() > before) Execute(client.commands.back());
  }

  ScriptedClient client;
  std::vector<double> cost_us;
  std::vector<double> lane_cost_us;
  bool ends_trials = true;
  int disturbed_trial_count = 0;  // trials whose first frame takes five times as long
  int ended_trial_count = 0;
  int over_limit_frame_count = 0;  // over 1.2 times the longest of the arm before
  std::vector<int> frame_counts = std::vector<int>(cost_us.size());

 private:
  double Noisy(double cost, double deviation) {
    return cost * std::exp(deviation * DrawNormal(random_));
  }

  void Sweep() {
    ++sweep_;
    for (uint32_t arm = 0; arm < lane_cost_us.size(); ++arm) {
      const ShadowSample sample{
          .first_frame_index = sweep_,
          .detection_time_ns = static_cast<uint64_t>(1e3 * Noisy(lane_cost_us[arm], 0.03)),
          .arm = arm,
          .object_count = 1'000,
          .frame_count = 5};
      client.session.ObserveShadow({&sample, 1});
    }
  }

  void RunFrame() {
    Frame& frame = client.frame;
    frame.detection_time_ns = static_cast<uint64_t>(1e3 * Noisy(cost_us[client.arm], 0.01));
    if (arm_before_ && disturbed_trial_count > 0) {
      --disturbed_trial_count;
      frame.detection_time_ns *= 5;
    }
    frame.frame_time_ns = frame.detection_time_ns;
    ++frame_counts[client.arm];
    client.RunFrame();
    if (!arm_before_) {
      longest_ns_ = std::max(longest_ns_, frame.detection_time_ns);
      return;
    }
    trial_left_ns_ -= static_cast<int64_t>(frame.frame_time_ns);
    if (frame.detection_time_ns > longest_ns_ * 6 / 5) {
      ++over_limit_frame_count;
      if (ends_trials) return EndTrial(frame.detection_time_ns);
    }
    if (trial_left_ns_ <= 0) Forget();
  }

  // From now on another arm is the one to compare with.
  void Forget() {
    arm_before_.reset();
    longest_ns_ = 0;
  }

  void Execute(const SwitchCommand& command) {
    if (command.trial_limit_percent > 0) {
      EXPECT_EQ(command.trial_limit_percent, 120u);
      arm_before_ = client.arm;
      trial_left_ns_ = 4 * kSecond;  // twice the settling time
    } else {
      Forget();
    }
    client.Execute(command.arm, command.reason);
  }

  void EndTrial(uint64_t detection_ns) {
    ++ended_trial_count;
    const TrialEnd end{.arm = client.arm, .detection_time_ns = detection_ns};
    client.arm = *std::exchange(arm_before_, std::nullopt);
    client.session.ObserveSwitch(client.arm, ++client.epoch, SwitchReason::kPolicy, client.now_ns,
                                 {.ended_trial = end});
  }

  RandomStream random_{5, RandomPurpose::kChoice, 0, 0};
  uint64_t sweep_ = 0;
  uint64_t longest_ns_ = 0;
  std::optional<uint32_t> arm_before_;  // while there is a trial
  int64_t trial_left_ns_ = 0;
};

TEST(Trial, AnArmHasALimitUntilItsFirstWindow) {
  TrialGame game({20'000, 10'000}, {22'000, 11'000});
  game.RunTicks(10);
  ASSERT_EQ(game.client.commands.size(), 1u);
  EXPECT_EQ(game.client.commands[0].arm, 1u);
  EXPECT_EQ(game.client.commands[0].trial_limit_percent, 120u);
  EXPECT_EQ(game.ended_trial_count, 0);
  game.cost_us = game.lane_cost_us = {10'000, 30'000};
  game.RunTicks(20);
  game.cost_us = game.lane_cost_us = {30'000, 10'000};
  game.RunTicks(20);
  ASSERT_EQ(game.client.commands.size(), 3u);
  EXPECT_EQ(game.client.commands[1].trial_limit_percent, 0u) << "it was live at the start";
  EXPECT_EQ(game.client.commands[2].trial_limit_percent, 0u);
}

TEST(Trial, WhileLearningOneFrameOfATrialAtMostIsOverItsLimit) {
  const std::vector<double> costs_us = {10'000, 40'000, 30'000, 9'000};
  const std::vector<double> lane_costs_us = {11'000, 8'000, 9'000, 10'000};
  TrialGame game(costs_us, lane_costs_us);
  game.RunTicks(300);
  EXPECT_EQ(game.ended_trial_count, 4) << "an arm is tried twice, not over and over";
  EXPECT_EQ(game.over_limit_frame_count, game.ended_trial_count);
  EXPECT_EQ(game.client.arm, 3u);
  TrialGame patient(costs_us, lane_costs_us);
  patient.ends_trials = false;
  patient.RunTicks(300);
  EXPECT_GT(patient.over_limit_frame_count, 100);
}

TEST(Trial, AnArmThatTheLaneFindsTwoFifthsDearerIsWorthItsBudget) {
  TrialGame game({10'000, 7'000}, {10'000, 14'000});
  game.RunTicks(30);
  EXPECT_EQ(game.client.arm, 1u);
}

TEST(Trial, AnArmThatTheLaneFindsTwiceAsDearIsNotWorthIt) {
  TrialGame game({10'000, 7'000}, {10'000, 20'000});
  game.RunTicks(100);
  EXPECT_EQ(game.frame_counts[1], 0);
}

TEST(Trial, WhatInterruptsOneKeepsNoGameFromTheBestArm) {
  TrialGame game({20'000, 10'000}, {22'000, 11'000});
  game.disturbed_trial_count = 1;
  game.RunTicks(20);
  EXPECT_EQ(game.ended_trial_count, 1);
  EXPECT_EQ(game.client.arm, 1u);
}

TEST(Trial, AnEndIsALowerBoundAndNoBan) {
  TrialGame game({10'000, 40'000}, {11'000, 8'000});
  game.RunTicks(20);
  EXPECT_GE(game.ended_trial_count, 1);
  const std::vector<BetaPosterior> posteriors(game.client.session.posteriors().begin(),
                                              game.client.session.posteriors().end());
  EXPECT_LT(posteriors[1].mean(), posteriors[0].mean());
  EXPECT_EQ(game.client.session.counts().charged_bail_out_count, 0u);
  // Of what was true before nothing is left, and the lane shows it.
  game.cost_us = {10'000, 3'000};
  game.lane_cost_us = {11'000, 600};
  game.RunTicks(60);
  EXPECT_EQ(game.client.arm, 1u);
  EXPECT_GT(game.frame_counts[1], 100);
}

TEST(Trial, AnEndIsLearntInManualModeByNobody) {
  TrialGame game({10'000, 12'000}, {11'000, 13'000});
  game.RunTicks(5);
  game.client.session.SetMode(Mode::kManual, 0, game.client.now_ns);
  const std::vector<BetaPosterior> before(game.client.session.posteriors().begin(),
                                          game.client.session.posteriors().end());
  game.client.session.ObserveSwitch(
      0, ++game.client.epoch, SwitchReason::kPolicy, game.client.now_ns,
      {.ended_trial = TrialEnd{.arm = 1, .detection_time_ns = 50'000'000}});
  const auto after = game.client.session.posteriors();
  EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin(), after.end()));
}

}  // namespace
}  // namespace sweepstake::decision
