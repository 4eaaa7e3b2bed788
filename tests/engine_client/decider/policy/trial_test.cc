// Tests the trials of "AI Decides" in a game whose lane misjudges an arm. Like all clients, the
// game itself ends trials that are too slow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/adaptive/guards/trial_guard.h"
#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/decider/policy/adaptive_policy.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

// The policy assumes the same trial budget as the clients' guard. A trial lasts two settling times.
static_assert(AdaptivePolicy::kTrialBudget * TrialGuard::kBudgetShare == 1);

// Number of the frame that is five times as long in a disturbed trial.
constexpr uint32_t kDisturbedFrame = 1 + kShadowWarmUpFrames + 2;

SessionSetup TrialSetup(uint32_t arm_count, bool stops_trials = true) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.policy = "adaptive";
  setup.stops_trials = stops_trials;
  return setup;
}

// A game whose frame time is all detection. The cost of an arm and the lane's measurement of it may
// differ.
class TrialGame {
 public:
  TrialGame(std::vector<double> costs_us, std::vector<double> lane_costs_us,
            bool stops_trials = true)
      : client(TrialSetup(static_cast<uint32_t>(costs_us.size()), stops_trials)),
        ends_trials(stops_trials),
        cost_us(std::move(costs_us)),
        lane_cost_us(std::move(lane_costs_us)) {
    client.obedient = false;
  }

  void RunTicks(int count) {
    for (int i = 0; i < count; ++i) RunTick();
  }

  void RunTick() {
    if (lane_reports) Sweep();
    while (client.now_ns < client.session.next_tick_ns()) RunFrame();
    const size_t before = client.commands.size();
    const DecisionRecord record = client.RunToTick().record;
    gate = record.gate;
    if (client.commands.size() > before) Execute(client.commands.back());
  }

  ScriptedClient client;
  bool ends_trials;
  std::vector<double> cost_us;
  std::vector<double> lane_cost_us;
  std::vector<uint32_t> lane_flags = std::vector<uint32_t>(lane_cost_us.size());
  bool lane_reports = true;
  std::optional<GateTerms> gate;  // gate of the latest decision
  int disturbed_trial_count = 0;  // number of trials in which a frame takes five times as long
  int ended_trial_count = 0;
  std::vector<uint32_t> frame_counts = std::vector<uint32_t>(cost_us.size());
  uint32_t rebuild_period = 0;  // every so many searches of arm 1 take three times as long

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
          .frame_count = 5,
          .flags = lane_flags[arm]};
      client.session.ObserveShadow({&sample, 1});
    }
  }

  void RunFrame() {
    FrameSample& frame = client.frame;
    frame.detection_time_ns = Search();
    ++frame_of_run_;
    if (disturbed_trial_count > 0 && is_trial_ && frame_of_run_ == kDisturbedFrame) {
      frame.detection_time_ns *= 5;
      --disturbed_trial_count;
    }
    const std::optional<uint64_t> limit_ns = guard_.limit_ns();
    const bool is_stopped = ends_trials && limit_ns && frame.detection_time_ns > *limit_ns;
    if (is_stopped) {
      EndTrial(guard_.Stop(*limit_ns));
      frame.detection_time_ns = *limit_ns + Search();
    }
    frame.frame_time_ns = frame.detection_time_ns;
    client.RunFrame();
    FrameSample sample{};
    sample.arm = client.arm;
    sample.frame_time_ns = frame.frame_time_ns;
    sample.detection_time_ns = frame.detection_time_ns;
    if (is_stopped) return;
    const auto end = guard_.OnFrame(sample);
    if (end && ends_trials) EndTrial(*end);
  }

  uint64_t Search() {
    const uint32_t count = ++frame_counts[client.arm];
    if (client.arm == 1 && rebuild_period > 0 && count % rebuild_period == 0)
      return static_cast<uint64_t>(3e3 * cost_us[1]);
    return static_cast<uint64_t>(1e3 * Noisy(cost_us[client.arm], 0.01));
  }

  void Execute(const SwitchCommand& command) {
    is_trial_ = command.trial_limit_percent > 0;
    EXPECT_TRUE(!is_trial_ || command.trial_limit_percent == 120);
    frame_of_run_ = 0;
    guard_.Begin(client.arm, {.trial_limit_percent = command.trial_limit_percent}, 4 * kSecond,
                 /*is_built=*/true);
    client.Execute(command.arm, command.reason);
  }

  void EndTrial(const TrialGuard::End& guard_end) {
    ++ended_trial_count;
    is_trial_ = false;
    const TrialEnd end{.arm = client.arm, .detection_time_ns = guard_end.detection_time_ns};
    client.arm = guard_end.arm_before;
    client.session.ObserveSwitch(client.arm, ++client.epoch, SwitchReason::kPolicy, client.now_ns,
                                 {.ended_trial = end});
  }

  RandomStream random_{5, RandomPurpose::kChoice, 0, 0};
  uint64_t sweep_ = 0;
  TrialGuard guard_;
  bool is_trial_ = false;
  uint32_t frame_of_run_ = 0;
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
  EXPECT_EQ(game.client.commands[1].trial_limit_percent, 0u) << "the arm was live at the start";
  EXPECT_EQ(game.client.commands[2].trial_limit_percent, 0u);
}

TEST(Trial, AnArmThatIsTooExpensiveRunsForOneFrame) {
  const std::vector<double> costs_us = {10'000, 40'000, 30'000, 9'000};
  const std::vector<double> lane_costs_us = {11'000, 8'000, 9'000, 10'000};
  TrialGame game(costs_us, lane_costs_us);
  game.RunTicks(300);
  EXPECT_LE(game.ended_trial_count, 8) << "each of the two arms is tried at most four times";
  EXPECT_EQ(game.frame_counts[1] + game.frame_counts[2], game.ended_trial_count);
  EXPECT_EQ(game.client.arm, 3u);
  TrialGame patient(costs_us, lane_costs_us);
  patient.ends_trials = false;
  patient.RunTicks(300);
  EXPECT_GT(patient.frame_counts[1] + patient.frame_counts[2], 100u);
}

TEST(Trial, AClientThatDoesNotStopTrialsIsSentNone) {
  TrialGame game({20'000, 10'000}, {22'000, 11'000}, /*stops_trials=*/false);
  game.RunTicks(10);
  ASSERT_EQ(game.client.commands.size(), 1u);
  EXPECT_EQ(game.client.commands[0].arm, 1u);
  EXPECT_EQ(game.client.commands[0].trial_limit_percent, 0u);
}

TEST(Trial, AnArmThatCostsFortyPercentMoreInTheLaneIsTried) {
  TrialGame game({10'000, 7'000}, {10'000, 14'000});
  game.RunTicks(30);
  EXPECT_EQ(game.client.arm, 1u);
}

// Each trial ends at the first rebuild, but its mean search is cheap.
TEST(Trial, AnArmThatRebuildsInEachTrialIsUsed) {
  TrialGame game({10'000, 5'000}, {10'000, 6'000});
  game.rebuild_period = 20;
  game.RunTicks(20);
  EXPECT_EQ(game.ended_trial_count, 3);
  EXPECT_EQ(game.client.arm, 1u);
}

TEST(Trial, TheLongerTheRegimeTheLessProbableAGainIsTried) {
  const auto first_try = [](double lane_cost_us) {
    TrialGame game({10'000, 7'000}, {10'000, lane_cost_us});
    int ticks = 0;
    for (; ticks < 1'000 && game.frame_counts[1] == 0; ++ticks) game.RunTick();
    return ticks;
  };
  EXPECT_LT(first_try(14'000), 5);
  EXPECT_GT(first_try(20'000), 10);
  EXPECT_EQ(first_try(50'000), 1'000) << "not tried";
}

// The lane's visits of the second arm are capped at 11 ms: the arm may take seconds.
TEST(Trial, AnArmWithOnlyCappedVisitsIsNotTried) {
  const std::vector<double> costs_us = {10'000, 500'000};
  const std::vector<double> lane_costs_us = {10'000, 11'000};
  TrialGame game(costs_us, lane_costs_us);
  game.lane_flags[1] = kShadowCapped;
  game.RunTicks(100);
  EXPECT_EQ(game.frame_counts[1], 0u);
  TrialGame measured(costs_us, lane_costs_us);
  measured.RunTicks(100);
  EXPECT_GT(measured.frame_counts[1], 0u);
}

// After a visit, the lane counts as present for one cooldown of 40 s, that is 40 ticks.
TEST(Trial, ALaneWithRareVisitsCountsAsPresent) {
  TrialGame game({10'000, 500'000}, {10'000, 9'000});
  game.lane_flags[1] = kShadowCapped;
  game.RunTicks(3);
  game.lane_reports = false;
  game.RunTicks(39);
  EXPECT_EQ(game.frame_counts[1], 0u);
  game.RunTicks(3);
  EXPECT_GT(game.frame_counts[1], 0u);
}

TEST(Trial, ACappedVisitDoesNotOutweighPriors) {
  SessionSetup setup = TrialSetup(2);
  setup.priors = {BetaOf({LogCostOf(10'000), 0.01}), BetaOf({LogCostOf(20'000), 0.01})};
  ScriptedClient client(setup);
  client.frame.detection_time_ns = client.frame.frame_time_ns = 10'000'000;
  const std::vector<ShadowSample> samples = {
      {.first_frame_index = 1, .detection_time_ns = 10'000'000, .arm = 0, .frame_count = 5},
      {.first_frame_index = 1, .detection_time_ns = 1'000'000, .arm = 1, .flags = kShadowCapped}};
  client.session.ObserveShadow(samples);
  client.RunToTick();
  client.RunToTick();
  EXPECT_GT(client.session.diagnosis().best_probability.at(0), 0.9);
  EXPECT_TRUE(client.commands.empty());
}

// Returns the gate of a switch that is too expensive, to an arm that is probably worse.
GateTerms GateOfAnExpensiveSwitch(bool stops_trials) {
  TrialGame game({10'000, 13'000}, {10'000, 14'000}, stops_trials);
  const SwitchCost cost{.rebuild_time_ns = 100 * kSecond};
  for (int i = 0; i < 20; ++i) {
    game.client.session.ObserveSwitch(0, game.client.epoch, SwitchReason::kPolicy,
                                      game.client.now_ns, cost);
  }
  game.RunTicks(5);
  EXPECT_TRUE(game.gate);
  return game.gate.value_or(GateTerms{});
}

// An arm that stays because it is within the budget causes its loss until the cooldown ends.
TEST(Trial, TheGateAssumesTheLossOfTheBudgetForTheWholeCooldown) {
  const GateTerms gate = GateOfAnExpensiveSwitch(/*stops_trials=*/true);
  EXPECT_EQ(gate.cooldown_s, 2) << "settling and one interval";
  EXPECT_NEAR(gate.loss, AdaptivePolicy::kTrialBudget, 1e-4);
}

TEST(Trial, TheGateDoesNotLimitTheLossOfAClientThatDoesNotStopTrials) {
  EXPECT_GT(GateOfAnExpensiveSwitch(/*stops_trials=*/false).loss, 4 * AdaptivePolicy::kTrialBudget);
}

TEST(Trial, AnInterruptedTrialDoesNotPreventTheBestArm) {
  TrialGame game({20'000, 10'000}, {22'000, 11'000});
  game.disturbed_trial_count = 1;
  game.RunTicks(20);
  EXPECT_EQ(game.ended_trial_count, 1);
  EXPECT_EQ(game.client.arm, 1u);
}

TEST(Trial, AnEndedTrialIsRepeatedAtMostTwice) {
  TrialGame game({10'000, 13'000}, {10'000, 13'000});
  game.RunTicks(300);
  EXPECT_LE(game.ended_trial_count, 3);
  EXPECT_EQ(game.client.arm, 0u);
}

// The third arm saves less than the second arm possibly could.
TEST(Trial, AnEndedTrialDoesNotPreventATrialOfAnotherArm) {
  TrialGame game({10'000, 13'000, 10'200}, {10'000, 11'000, 10'200});
  game.RunTicks(100);
  game.cost_us[2] = game.lane_cost_us[2] = 9'500;
  game.RunTicks(60);
  EXPECT_EQ(game.client.arm, 2u);
}

// While the lane works, a slowdown of live windows that the lane does not show is attributed to
// other work.
TEST(Trial, WithoutTheLaneAnArmWhoseCostRisesIsLeft) {
  TrialGame game({20'000, 10'000}, {22'000, 11'000});
  game.RunTicks(20);
  ASSERT_EQ(game.client.arm, 1u);
  game.lane_reports = false;
  game.RunTicks(150);
  game.cost_us[1] = 40'000;
  game.RunTicks(50);
  EXPECT_EQ(game.client.arm, 0u);
}

// In a scene with several regimes, live windows may show a new regime before the lane does.
TEST(Trial, ASlowdownIsPartlyAttributedToTheArmInAChangingScene) {
  const auto sure_after_a_rise = [](bool scene_changes) {
    TrialGame game({12'000, 10'000}, {13'200, 11'000});
    for (int tick = 0; tick < 60; ++tick) {
      SceneDescriptor descriptor;
      descriptor.object_count = 1'000;
      descriptor.speed_mean = scene_changes && tick < 30 ? 0.001F : 0.1F;
      game.client.session.ObserveDescriptor(descriptor);
      game.RunTick();
    }
    EXPECT_EQ(game.client.arm, 1u);
    game.lane_reports = false;
    game.cost_us[1] = 30'000;
    game.RunTicks(2);
    return game.client.session.diagnosis().best_probability[1];
  };
  EXPECT_GT(sure_after_a_rise(false), 0.8);
  EXPECT_LT(sure_after_a_rise(true), 0.6);
}

TEST(Trial, AnEndedTrialIsALowerBoundAndNotABan) {
  TrialGame game({10'000, 40'000}, {11'000, 8'000});
  game.RunTicks(20);
  EXPECT_GE(game.ended_trial_count, 1);
  const std::vector<BetaPosterior> posteriors(game.client.session.posteriors().begin(),
                                              game.client.session.posteriors().end());
  EXPECT_LT(posteriors[1].mean(), posteriors[0].mean());
  EXPECT_EQ(game.client.session.counts().charged_bail_out_count, 0u);
  // Now all costs have changed, and the lane shows it.
  game.cost_us = {10'000, 3'000};
  game.lane_cost_us = {11'000, 600};
  game.RunTicks(60);
  EXPECT_EQ(game.client.arm, 1u);
  EXPECT_GT(game.frame_counts[1], 100u);
}

TEST(Trial, AnEndedTrialTeachesNothingInManualMode) {
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
