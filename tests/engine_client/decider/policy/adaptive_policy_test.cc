// Tests the policy of "AI Decides" in complete sessions of a scripted game, with and without the
// shadow lane.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

SessionSetup AdaptiveSetup(uint32_t arm_count) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.policy = "adaptive";
  return setup;
}

// Returns Beta priors of reward version 3 with these costs and much evidence, such as the sums of a
// store.
std::vector<BetaPosterior> PriorsOf(const std::vector<double>& cost_us) {
  std::vector<BetaPosterior> priors;
  for (const double cost : cost_us) {
    const double reward = 1 - std::log(1e3 * cost) / std::log(5e9);
    priors.push_back({1e7 * reward, 1e7 * (1 - reward)});
  }
  return priors;
}

SceneDescriptor MovingAt(float speed) {
  SceneDescriptor descriptor;
  descriptor.speed_mean = speed;
  return descriptor;
}

// A game whose frame time is all detection, unless frame_time_ratio is set.
class Game {
 public:
  explicit Game(std::vector<double> costs_us, bool lane = true)
      : Game(AdaptiveSetup(static_cast<uint32_t>(costs_us.size())), costs_us, lane) {}
  Game(const SessionSetup& setup, std::vector<double> costs_us, bool lane = true)
      : client(setup), cost_us(std::move(costs_us)), lane_on(lane) {}

  Decision RunToTick() {
    SetFrame();
    if (lane_on) Sweep();
    return client.RunToTick();
  }
  void RunTicks(int count) {
    for (int i = 0; i < count; ++i) RunToTick();
  }
  // Sends a bail-out: the active arm took six seconds for a frame.
  Decision BailOut() {
    const FrameSample stall{.frame_time_ns = 6'000'000'000,
                            .detection_time_ns = 6'000'000'000,
                            .object_count = 1'000,
                            .arm = client.arm,
                            .switch_epoch = client.epoch};
    return client.session.ObserveBailOut(stall, client.now_ns);
  }
  // Runs `count` ticks and returns after how many of them this arm is active.
  int TicksOn(uint32_t arm, int count) {
    int ticks = 0;
    for (int i = 0; i < count; ++i) {
      RunToTick();
      ticks += client.arm == arm ? 1 : 0;
    }
    return ticks;
  }

  ScriptedClient client;
  std::vector<double> cost_us;
  bool lane_on;
  std::vector<double> lane_ratio =
      std::vector<double>(cost_us.size(), 1.1);  // cost in the lane ÷ cost on the frame thread
  double frame_time_ratio = 1;                   // frame time ÷ detection time
  double frame_load = 1;  // factor by which other work on the core slows the frames

 private:
  // Sets the cost of the frames until the next tick, with 1 % noise.
  void SetFrame() {
    const double cost = frame_load * cost_us[client.arm] * std::exp(0.01 * DrawNormal(random_));
    client.frame.detection_time_ns = static_cast<uint64_t>(cost * 1e3);
    client.frame.frame_time_ns = static_cast<uint64_t>(frame_time_ratio * cost * 1e3);
  }

  void Sweep() {
    ++sweep_;
    for (uint32_t arm = 0; arm < cost_us.size(); ++arm) {
      const double cost = lane_ratio[arm] * cost_us[arm] * std::exp(0.03 * DrawNormal(random_));
      const ShadowSample sample{.first_frame_index = sweep_,
                                .detection_time_ns = static_cast<uint64_t>(cost * 1e3),
                                .arm = arm,
                                .object_count = 1'000,
                                .frame_count = 5};
      client.session.ObserveShadow({&sample, 1});
    }
  }

  RandomStream random_{3, RandomPurpose::kChoice, 0, 0};
  uint64_t sweep_ = 0;
};

TEST(AdaptivePolicy, IsOnTheCheapestArmAfterTheFirstSweepWithAnyCooldown) {
  SessionSetup setup = AdaptiveSetup(4);
  for (const int64_t cooldown_ns : {40 * kSecond, 1 * kSecond, 0 * kSecond}) {
    setup.options.cooldown_ns = cooldown_ns;
    Game game(setup, {90'000, 12'000, 10'000, 20'000});
    game.RunTicks(2);  // the first window has only settling frames
    EXPECT_EQ(game.client.arm, 2u) << cooldown_ns;
    EXPECT_GE(game.TicksOn(2, 100), 90) << cooldown_ns;
  }
}

TEST(AdaptivePolicy, NeverRunsAnArmThatTheLaneShowsToBeFarWorse) {
  Game game({90'000, 12'000, 10'000, 80'000});
  game.RunTicks(100);
  for (const SwitchCommand& command : game.client.commands) EXPECT_NE(command.arm % 3, 0u);
}

TEST(AdaptivePolicy, TriesAnArmThatTheLaneMayMisjudge) {
  Game game({10'000, 11'000, 30'000});
  game.lane_ratio = {1.1, 0.9, 1};  // the lane underestimates the second arm by a tenth
  game.RunTicks(20);
  EXPECT_EQ(game.client.arm, 0u);
  EXPECT_GE(game.TicksOn(0, 100), 99);
}

double CostUs(const Increment& increment) {
  return std::exp(LogCostOfReward(increment.alpha / (increment.alpha + increment.beta)));
}

// The lane takes 1.1 times as long as the frame thread, except for the last arm, which never runs
// live.
TEST(AdaptivePolicy, StoresVisitsConvertedToLiveCosts) {
  Game game({10'000, 30'000, 60'000});
  game.lane_ratio[2] = 1.3;
  game.RunTicks(100);
  const std::vector<Increment> visits = game.RunToTick().lane_increments;
  ASSERT_EQ(visits.size(), 3u);
  for (size_t i : {0, 1}) EXPECT_NEAR(CostUs(visits[i]) / game.cost_us[i], 1, 0.1);
  EXPECT_NEAR(CostUs(visits[2]) / 60'000, 1.3 / 1.1, 0.1);
}

TEST(AdaptivePolicy, AFloodOfVisitsCountsOnlyAsMuchAsALaneCanMeasure) {
  Game game({10'000, 30'000}, /*lane=*/false);
  const std::vector<ShadowSample> visits(200, {.detection_time_ns = 5'000, .arm = 1});
  game.client.session.ObserveShadow(visits);
  EXPECT_EQ(game.RunToTick().lane_increments.size(), 8u);
}

TEST(AdaptivePolicy, VisitsInManualModeAreNotEvidence) {
  Game game({10'000, 30'000});
  game.client.session.SetMode(Mode::kManual, 0, game.client.now_ns);
  EXPECT_TRUE(game.RunToTick().lane_increments.empty());
  game.client.session.SetMode(Mode::kAi, 0, game.client.now_ns);
  EXPECT_EQ(game.RunToTick().lane_increments.size(), 2u);
}

TEST(AdaptivePolicy, MeasurementsOutweighPriors) {
  SessionSetup setup = AdaptiveSetup(2);
  setup.priors = PriorsOf({1'000, 100'000});
  Game game(setup, {50'000, 10'000}, /*lane=*/false);
  for (uint32_t arm : {1u, 0u}) {
    const ShadowSample sample{.detection_time_ns = static_cast<uint64_t>(game.cost_us[arm] * 1e3),
                              .arm = arm};
    game.client.session.ObserveShadow({&sample, 1});
    game.RunToTick();
  }
  const auto beliefs = game.client.session.posteriors();
  EXPECT_GT(beliefs[1].mean(), beliefs[0].mean() + 0.05);
}

// For half an hour, the two arms take turns at being the cheaper one.
TEST(AdaptivePolicy, StaysIfAnotherArmCostsAlmostTheSame) {
  Game game({10'000, 10'050, 30'000});
  game.RunTicks(60);
  const size_t switch_count = game.client.commands.size();
  for (int i = 0; i < 30; ++i) {
    std::swap(game.cost_us[0], game.cost_us[1]);
    game.RunTicks(30);
  }
  EXPECT_LE(game.client.commands.size() - switch_count, 20u);
}

// Other work repeatedly uses the frame thread's core for 10 s.
TEST(AdaptivePolicy, StaysWhileOtherWorkMakesEveryArmSlower) {
  Game game({10'000, 14'000, 18'200});
  game.RunTicks(60);
  ASSERT_EQ(game.client.arm, 0u);
  const size_t switch_count = game.client.commands.size();
  int ticks = 0;
  for (int i = 0; i < 10; ++i) {
    game.frame_load = 3;
    ticks += game.TicksOn(0, 5);
    game.frame_load = 1;
    ticks += game.TicksOn(0, 25);
  }
  EXPECT_EQ(ticks, 300);
  EXPECT_EQ(game.client.commands.size(), switch_count);
}

// In manual mode, the diagnosis shows whether mode ai would be worthwhile.
TEST(AdaptivePolicy, LearnsFromTheLaneInManualModeAndCommandsNothing) {
  SessionSetup setup = AdaptiveSetup(3);
  setup.mode = Mode::kManual;
  Game game(setup, {20'000, 14'000, 10'000}, /*lane=*/true);
  game.RunTicks(20);
  EXPECT_TRUE(game.client.commands.empty());
  EXPECT_GT(game.client.session.diagnosis().best_probability[2], 0.8);
  game.client.session.SetMode(Mode::kAi, 0, game.client.now_ns);
  game.RunTicks(2);
  EXPECT_EQ(game.client.arm, 2U);
}

TEST(AdaptivePolicy, ACappedVisitIsALowerBoundOfTheCost) {
  const auto cost_us = [](uint64_t capped_us) {
    Game game({10'000, 40'000});
    game.RunTicks(20);
    const auto before = game.client.session.posteriors()[1].mean();
    game.lane_on = false;
    for (uint64_t sweep = 1000; sweep < 1010; ++sweep) {
      const ShadowSample sample{.first_frame_index = sweep,
                                .detection_time_ns = capped_us * 1000,
                                .arm = 1,
                                .object_count = 1'000,
                                .frame_count = 1,
                                .flags = kShadowCapped};
      game.client.session.ObserveShadow({&sample, 1});
    }
    game.RunToTick();
    return game.client.session.posteriors()[1].mean() - before;
  };
  EXPECT_NEAR(cost_us(15'000), 0, 0.01);
  EXPECT_LT(cost_us(400'000), -0.05);
}

TEST(AdaptivePolicy, FollowsASceneThatMakesAnotherArmCheaper) {
  Game game({10'000, 12'000, 30'000});
  game.RunTicks(30);
  ASSERT_EQ(game.client.arm, 0u);
  game.cost_us = {14'000, 11'000, 30'000};
  game.RunTicks(15);
  EXPECT_EQ(game.client.arm, 1u);
}

// The first arm is the best while the scene moves, the second one while it rests. The lane reports
// only in the first two minutes, so afterwards only stored beliefs identify the best arm.
TEST(AdaptivePolicy, AReturningRegimeRestoresItsBeliefs) {
  Game game({10'000, 14'000});
  const auto run_regime = [&](bool rests) {
    game.cost_us = rests ? std::vector<double>{15'000, 9'000} : std::vector<double>{10'000, 14'000};
    for (int tick = 0; tick < 15; ++tick) {
      game.client.session.ObserveDescriptor(MovingAt(rests ? 0.001F : 0.1F));
      game.RunToTick();
      if (tick == 2 && !game.lane_on) {
        EXPECT_EQ(game.client.arm, rests ? 1u : 0u);
      }
    }
  };
  for (const bool rests : {false, true, false, true}) run_regime(rests);
  game.lane_on = false;
  for (const bool rests : {false, true, false, true}) run_regime(rests);
}

TEST(AdaptivePolicy, TheDiagnosisStatesItsCertainty) {
  Game game({20'000, 12'000, 10'000});
  game.RunTicks(100);
  const Diagnosis& sure = game.client.session.diagnosis();
  EXPECT_EQ(sure.leader, 2u);
  EXPECT_GT(sure.best_probability[2], 0.9);
  Game tied({20'000, 10'010, 10'000});
  tied.RunTicks(100);
  EXPECT_LT(tied.client.session.diagnosis().expected_loss_ratio, 0.03);
}

TEST(AdaptivePolicy, WithoutALaneTriesEachArmLiveAndEndsOnTheCheapest) {
  Game game({20'000, 12'000, 10'000, 30'000}, /*lane=*/false);
  game.RunTicks(40);
  std::vector<uint32_t> tried;
  for (const SwitchCommand& command : game.client.commands) tried.push_back(command.arm);
  for (const uint32_t arm : {1u, 2u, 3u})
    EXPECT_NE(std::find(tried.begin(), tried.end(), arm), tried.end()) << arm;
  EXPECT_GE(game.TicksOn(2, 100), 90);
}

TEST(AdaptivePolicy, UsesALaneThatStartsLate) {
  Game game({20'000, 12'000, 10'000, 30'000}, /*lane=*/false);
  game.RunTicks(8);
  EXPECT_FALSE(game.client.commands.empty());
  game.lane_on = true;
  game.RunTicks(20);
  EXPECT_EQ(game.client.arm, 2u);
}

TEST(AdaptivePolicy, AnArmThatMayStallTheGameIsNotTriedLive) {
  Game game({3'500'000, 10'000});
  game.client.Execute(1, SwitchReason::kManual);
  game.RunTicks(10);
  game.cost_us[1] = 4'500'000;  // now the other arm would be better
  game.RunTicks(20);
  EXPECT_TRUE(game.client.commands.empty());
}

TEST(AdaptivePolicy, LeavesAnArmAtOnceAfterABailOut) {
  Game game({10'000, 12'000, 30'000});
  game.RunTicks(10);
  ASSERT_EQ(game.client.arm, 0u);
  const Decision decision = game.BailOut();
  ASSERT_TRUE(decision.command);
  EXPECT_EQ(decision.command->arm, 1u);
  EXPECT_EQ(decision.increment->bail_out_count, 1u);
}

TEST(AdaptivePolicy, ABailOutIsStoredWithTheWeightOfTenWindows) {
  Game game({10'000, 12'000});
  game.RunTicks(10);
  const auto window = game.RunToTick().increment;
  ASSERT_TRUE(window);
  const Decision decision = game.BailOut();
  EXPECT_EQ(decision.increment->alpha, 0);
  EXPECT_GT(window->alpha + window->beta, 1000);
  EXPECT_NEAR(decision.increment->beta / (window->alpha + window->beta), 10, 0.5);
}

TEST(AdaptivePolicy, ABailOutSwitchesEvenToAnArmThatIsUnsafe) {
  Game game({4'000'000, 4'500'000});
  game.RunTicks(10);
  ASSERT_EQ(game.client.arm, 0u);
  EXPECT_TRUE(game.BailOut().command);
}

TEST(AdaptivePolicy, WithoutALaneLeavesASlowArmHoweverSlowItIs) {
  for (const double slow_us : {3e5, 6e5, 9e5, 1.2e6, 2e6, 4e6}) {
    Game game({slow_us, 1e4, 2e4}, false);
    game.RunTicks(100);
    EXPECT_NE(game.client.arm, 0U) << slow_us;
  }
}

// Something other than the arm caused the bail-outs.
TEST(AdaptivePolicy, WithoutALaneOneBailOutExcludesAnArmOnlyForMinutes) {
  Game game({10'000, 12'000}, /*lane=*/false);
  game.RunTicks(20);
  ASSERT_EQ(game.client.arm, 0u);
  game.client.Execute(game.BailOut().command->arm, SwitchReason::kBailOut);
  EXPECT_EQ(game.TicksOn(0, 150), 0) << "two and a half minutes";
  EXPECT_GT(game.TicksOn(0, 100), 40);
  game.client.Execute(game.BailOut().command->arm, SwitchReason::kBailOut);
  EXPECT_EQ(game.TicksOn(0, 600), 0) << "a second bail-out counts four times as much";
}

TEST(AdaptivePolicy, APriorOfThisMachineDecidesBeforeTheFirstFrame) {
  SessionSetup setup = AdaptiveSetup(4);
  setup.priors = PriorsOf({9'000, 1'200, 1'000, 3'000});  // measured on a faster machine
  Game game(setup, {90'000, 12'000, 10'000, 30'000});
  EXPECT_EQ(game.client.session.Tick(game.client.now_ns).command->arm, 2u);
}

// The possible gain is not worth a trial of five frames of 0.1 s each.
TEST(AdaptivePolicy, WithoutALaneAnArmWithAHundredfoldPriorCostIsNotTried) {
  SessionSetup setup = AdaptiveSetup(2);
  setup.priors = PriorsOf({1'000, 100'000});
  Game game(setup, {1'000, 100'000}, /*lane=*/false);
  EXPECT_EQ(game.TicksOn(1, 200), 0);
}

TEST(AdaptivePolicy, TheFirstSweepOutweighsAWrongPrior) {
  SessionSetup setup = AdaptiveSetup(4);
  setup.priors = PriorsOf({1'000, 12'000, 10'000, 3'000});
  Game game(setup, {90'000, 12'000, 10'000, 30'000});
  game.RunTicks(2);
  EXPECT_EQ(game.client.arm, 2u);
  EXPECT_GE(game.TicksOn(2, 50), 45);
}

TEST(AdaptivePolicy, ASweepOfSeveralTicksOutweighsAWrongPrior) {
  SessionSetup setup = AdaptiveSetup(3);
  setup.priors = PriorsOf({1'000, 12'000, 10'000});
  Game game(setup, {20'000, 12'000, 10'000}, /*lane=*/false);
  for (const uint32_t arm : {0u, 1u, 2u}) {
    const ShadowSample sample{.first_frame_index = 1,
                              .detection_time_ns = static_cast<uint64_t>(game.cost_us[arm] * 1e3),
                              .arm = arm,
                              .object_count = 1'000,
                              .frame_count = 5};
    game.client.session.ObserveShadow({&sample, 1});
    game.RunToTick();
  }
  // With the prior, the mean of arm 0 would remain the highest.
  EXPECT_LT(game.client.session.posteriors()[0].mean(), game.client.session.posteriors()[2].mean());
  game.RunTicks(2);
  EXPECT_NE(game.client.arm, 0u);
}

TEST(AdaptivePolicy, AWrongPriorIsCorrectedWithoutALaneToo) {
  SessionSetup setup = AdaptiveSetup(3);
  setup.priors = PriorsOf({1'000, 2'000, 4'000});
  Game game(setup, {30'000, 20'000, 10'000}, /*lane=*/false);
  game.RunTicks(50);
  EXPECT_EQ(game.client.arm, 2u);
}

// A game with 100 frames/s and a descriptor every 20 frames.
class RegimeGame {
 public:
  RegimeGame() : client(AdaptiveSetup(2)) {}

  void PlayFrames(int count, uint64_t detection_us) {
    client.frame.detection_time_ns = detection_us * 1'000;
    for (int i = 0; i < count; ++i) {
      client.RunFrame();
      if (client.now_ns >= client.session.next_tick_ns()) last = client.session.Tick(client.now_ns);
    }
  }
  void PlayRest(int periods) { Play(periods, 0.001F, 1'000); }
  void PlayMotion(int periods) { Play(periods, 0.1F, 6'000); }
  void Visit(uint64_t frame_index) {
    const ShadowSample visit{.first_frame_index = frame_index,
                             .detection_time_ns = 3'000'000,
                             .arm = 1,
                             .frame_count = 5};
    client.session.ObserveShadow({&visit, 1});
  }

  ScriptedClient client;
  Decision last;

 private:
  void Play(int periods, float speed, uint64_t detection_us) {
    for (int i = 0; i < periods; ++i) {
      PlayFrames(20, detection_us);
      client.session.ObserveDescriptor(MovingAt(speed));
    }
  }
};

TEST(AdaptivePolicy, LearnsEvidenceInTheRegimeInWhichItWasMeasured) {
  RegimeGame game;
  game.PlayRest(25);
  game.PlayMotion(100);
  game.PlayRest(25);
  for (const uint64_t id = game.last.record.decision_id; game.last.record.decision_id == id;)
    game.PlayFrames(1, 1'000);
  const int64_t last_tick_ns = game.last.record.time_ns;
  game.PlayRest(2);
  const uint64_t last_rest = game.client.frame_index;
  game.PlayFrames(10, 1'000);
  game.PlayFrames(10, 6'000);
  game.client.session.ObserveDescriptor(MovingAt(0.01F));  // a mixture
  game.Visit(last_rest - 1);
  game.Visit(last_rest + 5);
  game.PlayMotion(1);
  EXPECT_EQ(game.last.record.time_ns, last_tick_ns) << "no tick so far";
  EXPECT_EQ(game.client.session.next_tick_ns(), last_tick_ns + kSecond / 4);
  game.PlayFrames(1, 6'000);
  EXPECT_GT(game.last.record.time_ns, last_tick_ns);
  EXPECT_LT(game.last.record.time_ns, last_tick_ns + kSecond);
  EXPECT_EQ(game.client.session.next_tick_ns(), game.last.record.time_ns + kSecond);
  ASSERT_TRUE(game.last.record.reward);
  EXPECT_NEAR(*game.last.record.reward, RewardOf(LogCostOf(1'000)), 1e-6) << "frames at rest only";
  EXPECT_EQ(game.last.lane_increments.size(), 1U) << "the visit in the mixture does not count";
  EXPECT_NEAR(LogCostOfReward(game.last.record.posteriors[0].mean()), LogCostOf(6'000), 0.02)
      << "the beliefs in motion, without the window at rest";
  game.PlayMotion(10);
  EXPECT_NEAR(*game.last.record.reward, RewardOf(LogCostOf(6'000)), 1e-6);
}

TEST(AdaptivePolicy, DecidesAtLeastEverySecond) {
  SessionSetup setup = AdaptiveSetup(2);
  EXPECT_EQ(ScriptedClient(setup).session.next_tick_ns(), kSecond);
  setup.options.decision_interval_ns = kSecond / 2;
  EXPECT_EQ(ScriptedClient(setup).session.next_tick_ns(), kSecond / 2);
  setup.options = AdaptiveSetup(2).options.Scaled(10);
  EXPECT_EQ(ScriptedClient(setup).session.next_tick_ns(), kSecond / 10);
  EXPECT_EQ(ScriptedClient(PlainSetup(2)).session.next_tick_ns(), 2 * kSecond) << "as in the paper";
}

TEST(AdaptivePolicy, ATimeScaleChangesNoDecision) {
  SessionSetup setup = AdaptiveSetup(3);
  Game game(setup, {30'000, 11'500, 10'000});
  setup.options = setup.options.Scaled(10);
  Game fast(setup, {3'000, 1'150, 1'000});
  for (int i = 0; i < 60; ++i) {
    const Decision slow_decision = game.RunToTick();
    const Decision fast_decision = fast.RunToTick();
    ASSERT_EQ(fast_decision.record.outcome, slow_decision.record.outcome) << i;
    ASSERT_EQ(fast_decision.record.candidate, slow_decision.record.candidate) << i;
  }
}

// Detection takes 1 % of the frame. A switch costs at most 2 s, settling and one interval, which is
// as much as 200 s of detection.
TEST(AdaptivePolicy, AGainMustPayForTheMeasuredCostOfSwitches) {
  const auto switch_count = [](uint64_t cost_ns) {
    Game game({10'000, 12'000, 30'000});
    game.frame_time_ratio = 100;
    const SwitchCost cost{.rebuild_time_ns = cost_ns};
    for (int i = 0; i < 20; ++i) {
      game.client.session.ObserveSwitch(game.client.arm, game.client.epoch, SwitchReason::kPolicy,
                                        game.client.now_ns, cost);
    }
    game.cost_us = {12'000, 10'000, 30'000};
    game.RunTicks(60);
    return game.client.commands.size();
  };
  EXPECT_EQ(switch_count(1'000'000), 1u);
  EXPECT_EQ(switch_count(kSecond * 100), 0u);
}

TEST(AdaptivePolicy, TheHorizonIsTheMeanLengthOfTheRegimes) {
  RegimeGame game;
  game.Visit(0);
  game.PlayMotion(25);
  ASSERT_TRUE(game.last.record.gate);
  EXPECT_EQ(game.last.record.gate->horizon_s, 45) << "5 s have passed, and 40 s are expected";
  for (int i = 0; i < 20; ++i) {
    game.PlayRest(25);
    game.PlayMotion(25);
  }
  ASSERT_TRUE(game.last.record.gate);
  EXPECT_NEAR(game.last.record.gate->horizon_s, 6, 0.3) << "41 regimes of 5 s, and 40 s";
}

TEST(AdaptivePolicy, CountsARebuildAmongTheSettlingFramesOnce) {
  const auto cost_s = [](const SwitchCost& cost) {
    Game game({20'000, 10'000, 10'500});
    game.RunToTick();
    game.client.session.ObserveSwitch(game.client.arm, game.client.epoch, SwitchReason::kPolicy,
                                      game.client.now_ns, cost);
    game.RunToTick();
    game.RunToTick();
    return game.RunToTick().record.gate->cost_s;
  };
  const double settled = cost_s({.rebuild_time_ns = 0, .settling_cost_ns = 300'000'000});
  EXPECT_EQ(cost_s({.rebuild_time_ns = 300'000'000, .settling_cost_ns = 300'000'000}), settled);
  EXPECT_LT(cost_s({.rebuild_time_ns = 0, .settling_cost_ns = 0}), settled);
}

TEST(AdaptivePolicy, ThePublishedBeliefsNarrowWithEvidence) {
  Game game({10'000, 12'000});
  const double early = game.client.session.posteriors()[1].evidence();
  game.RunTicks(50);
  EXPECT_GT(game.client.session.posteriors()[1].evidence(), 2 * early);
}

TEST(AdaptivePolicy, StoresALiveWindowAsABetaOfItsPrecision) {
  Game game({10'000, 12'000}, /*lane=*/false);
  game.RunTicks(60);
  const Decision decision = game.RunToTick();
  ASSERT_TRUE(decision.increment);
  const double evidence = decision.increment->alpha + decision.increment->beta;
  const double reward = 1 - std::log(1e3 * game.cost_us[decision.increment->arm]) / std::log(5e9);
  EXPECT_NEAR(decision.increment->alpha / evidence, reward, 0.01);
  EXPECT_GT(evidence, 1'000);  // noise of a few % of the cost is a few ‰ of the reward
}

// Arm 0 runs, arm 1 is cheaper by a quarter, arm 2 costs twice as much.
TEST(Standings, CountLiveWindowsAndVisitsAndWeighBoth) {
  Game game({400, 300, 800});
  game.client.obedient = false;
  game.RunTicks(20);
  const auto standings = game.client.session.standings();
  EXPECT_EQ(standings[0].live_window_count, 19u) << "the first window has only settling frames";
  EXPECT_EQ(standings[1].live_window_count, 0u);
  for (const ArmStanding& standing : standings) EXPECT_GE(standing.lane_visit_count, 20u);
  // The lane's bias is unknown. Therefore even many visits of an arm have only the information of
  // about one window.
  EXPECT_GT(standings[2].effective_window_count, 0.001);
  EXPECT_LT(standings[2].effective_window_count, 2);
  ASSERT_EQ(game.client.session.diagnosis().leader, 1u);
  EXPECT_EQ(standings[1].cost_ratio, CostRatio{});
  const CostRatio ratio = *standings[2].cost_ratio;
  EXPECT_NEAR(ratio.median, 800.0 / 300, 0.3);
  EXPECT_LT(ratio.low, 800.0 / 300);
  EXPECT_GT(ratio.high, 800.0 / 300);
  EXPECT_GT(ratio.low, 1);
}

// Old windows lose weight, because costs drift.
TEST(Standings, TheEffectiveWindowCountIsBelowTheCount) {
  Game game({300, 400}, /*lane=*/false);
  game.client.obedient = false;
  game.RunTicks(400);
  const ArmStanding standing = game.client.session.standings()[0];
  EXPECT_EQ(standing.live_window_count, 399u);
  EXPECT_EQ(standing.lane_visit_count, 0u);
  EXPECT_LT(standing.effective_window_count, 40);
}

}  // namespace
}  // namespace sweepstake::decision
