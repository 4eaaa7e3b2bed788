// Tests the report per regime in complete sessions of a scripted game.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

SessionSetup AdaptiveSetup() {
  SessionSetup setup = PlainSetup(2);
  setup.arms.push_back("KDTree");
  setup.options.policy = "adaptive";
  return setup;
}

// A game whose frame time is all detection, without noise. The lane measures all arms at each tick.
class ChangingGame {
 public:
  explicit ChangingGame(const SessionSetup& setup = AdaptiveSetup()) : client(setup) {}

  // Plays a regime that costs_us and the descriptor define.
  void Play(const std::vector<double>& costs_us, const SceneDescriptor& descriptor, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      client.session.ObserveDescriptor(descriptor);
      client.frame.detection_time_ns = static_cast<uint64_t>(1e3 * costs_us[client.arm]);
      client.frame.frame_time_ns = client.frame.detection_time_ns;
      for (uint32_t arm = 0; arm < costs_us.size(); ++arm) Visit(arm, costs_us[arm]);
      const uint64_t first = client.frame_index;
      const double ran_us = costs_us[client.arm];
      client.RunToTick();
      const auto frames = static_cast<double>(client.frame_index - first);
      for (size_t arm = 0; arm < costs_us.size(); ++arm)
        saved_us[arm] += frames * (costs_us[arm] - ran_us);
    }
  }
  double SavedPerFrame(size_t arm) const {
    return saved_us[arm] / static_cast<double>(client.frame_index);
  }

  ScriptedClient client;
  std::vector<double> saved_us = std::vector<double>(3);  // against each arm

 private:
  void Visit(uint32_t arm, double cost_us) {
    const ShadowSample sample{.first_frame_index = client.frame_index,
                              .detection_time_ns = static_cast<uint64_t>(1e3 * cost_us),
                              .arm = arm,
                              .object_count = 1'000,
                              .frame_count = 5};
    client.session.ObserveShadow({&sample, 1});
  }
};

SceneDescriptor DescriptorOf(float speed) {
  SceneDescriptor descriptor;
  descriptor.object_count = 2'000;
  descriptor.speed_mean = speed;
  return descriptor;
}

const std::vector<double> kMovingUs = {10'000, 14'000, 20'000};
const std::vector<double> kRestingUs = {15'000, 9'000, 21'000};
// The first arm is so much cheaper than the others that these are not tried.
const std::vector<double> kConstantUs = {10'000, 40'000, 60'000};

void PlayMoving(ChangingGame& game, int ticks) { game.Play(kMovingUs, DescriptorOf(0.1F), ticks); }
void PlayResting(ChangingGame& game, int ticks) {
  game.Play(kRestingUs, DescriptorOf(0.001F), ticks);
}

// Without a lane and before any frame, all arms have the same belief, which says nothing.
TEST(Standings, AnArmWithoutAMeasuredCostHasNoRatio) {
  ScriptedClient client(AdaptiveSetup());
  client.session.Tick(client.session.next_tick_ns());
  EXPECT_EQ(client.session.diagnosis().verdict, Verdict::kUnknown);
  for (const ArmStanding& standing : client.session.standings()) EXPECT_FALSE(standing.cost_ratio);
  client.frame.detection_time_ns = client.frame.frame_time_ns = 10'000'000;
  client.RunToTick();
  EXPECT_NE(client.session.diagnosis().verdict, Verdict::kUnknown);
  EXPECT_FALSE(client.session.standings()[1].cost_ratio);
}

TEST(Report, DescribesTheRegimesOfAChangingScene) {
  ChangingGame game;
  for (int period = 0; period < 10; ++period) {
    PlayMoving(game, 20);
    PlayResting(game, 10);
  }
  const SceneReport scene = game.client.session.Report();
  ASSERT_EQ(scene.regimes.size(), 2u);
  const RegimeReport& moving = scene.regimes[0];
  const RegimeReport& resting = scene.regimes[1];
  EXPECT_EQ(moving.best_arm, 0u);
  EXPECT_EQ(resting.best_arm, 1u);
  EXPECT_GT(moving.arms[0].best_probability, 0.9);
  EXPECT_GT(resting.arms[1].best_probability, 0.9);
  EXPECT_NEAR(moving.arms[0].cost->us, 10'000, 300);
  EXPECT_NEAR(resting.arms[1].cost->us, 9'000, 300);
  EXPECT_FALSE(moving.is_present);
  EXPECT_TRUE(resting.is_present);
  EXPECT_NEAR(*moving.centre.object_count, 2'000, 1);
  EXPECT_NEAR(*moving.centre.speed_mean, 0.1, 1e-3);
  EXPECT_NEAR(*resting.centre.speed_mean, 0.001, 1e-5);
  EXPECT_FALSE(resting.centre.static_ratio);
  EXPECT_NEAR(moving.frame_share, 2.0 / 3, 0.05);
  EXPECT_NEAR(moving.frame_share + resting.frame_share, 1, 1e-9);
}

TEST(Report, SavesWhatTheGameSaved) {
  ChangingGame game;
  for (int period = 0; period < 10; ++period) {
    PlayMoving(game, 20);
    PlayResting(game, 20);
  }
  const SceneReport scene = game.client.session.Report();
  ASSERT_EQ(scene.total.best_arm, 1u);
  EXPECT_GT(game.SavedPerFrame(1), 500);
  EXPECT_NEAR(*scene.total.saved_against_single_us / game.SavedPerFrame(1), 1, 0.05);
  // KDTree is never live, so the lane's bias for it is not known.
  EXPECT_NEAR(*scene.total.saved_against_reference_us / game.SavedPerFrame(2), 1, 0.1);
}

// After a restart of the daemon the game runs another arm than the one with which it began.
TEST(Report, SavesAgainstTheInitialArmWhateverRunsAtTheStart) {
  SessionSetup setup = AdaptiveSetup();
  setup.initial_arm = 1;
  ChangingGame game(setup);
  game.Play(kConstantUs, DescriptorOf(0.1F), 100);
  ASSERT_TRUE(game.client.commands.empty());
  EXPECT_EQ(game.client.session.initial_arm(), 1u);
  const std::optional<double> saved_us =
      game.client.session.Report().total.saved_against_initial_us;
  EXPECT_NEAR(*saved_us, 30'000, 6'000);
  EXPECT_EQ(game.client.session.saved_us(), saved_us);
}

TEST(Report, TheTotalHasTheFiledFramesOnly) {
  ChangingGame game;
  game.Play(kConstantUs, DescriptorOf(0.1F), 10);
  const DecisionSession& session = game.client.session;
  const RegimeUse before = session.total_use();
  EXPECT_EQ(before.frame_count, session.counts().measured_frame_count);
  EXPECT_NEAR(before.ran_us / static_cast<double>(before.frame_count), 10'000, 1e-3);
  EXPECT_DOUBLE_EQ(before.arm_us[0], before.ran_us);
  EXPECT_GT(before.arm_us[1], before.ran_us);
  game.client.RunFrame();
  EXPECT_EQ(session.total_use().frame_count, before.frame_count) << "not filed yet";
  game.client.RunToTick();
  EXPECT_EQ(session.total_use().frame_count, session.counts().measured_frame_count);
}

// The frames between the end of a regime and the switch run the arm that was the best before.
TEST(Report, FilesTheFramesBeforeASwitchToTheNextRegime) {
  ChangingGame game;
  PlayMoving(game, 60);
  const double before = *game.client.session.Report().total.ran_us;
  PlayResting(game, 20);
  const SceneReport scene = game.client.session.Report();
  ASSERT_EQ(scene.regimes.size(), 2u);
  EXPECT_NEAR(*scene.regimes[0].ran_us, before, 1e-3);
  EXPECT_GT(*scene.regimes[1].ran_us, 9'100);
}

TEST(Report, SubtractsTheMeasuredCostOfSwitches) {
  ChangingGame game;
  PlayMoving(game, 30);
  const double before = *game.client.session.Report().total.ran_us;
  const auto frames = static_cast<double>(game.client.session.counts().measured_frame_count);
  game.client.session.ObserveSwitch(game.client.arm, game.client.epoch, SwitchReason::kPolicy,
                                    game.client.now_ns, {.settling_cost_ns = 2'000'000'000});
  const double after = *game.client.session.Report().total.ran_us;
  EXPECT_NEAR(after - before, 2e6 / frames, 0.05 * 2e6 / frames);
}

TEST(Report, AConstantSceneHasOneRegimeAndSavesNothingAgainstItsBestArm) {
  ChangingGame game;
  game.Play(kConstantUs, DescriptorOf(0.1F), 100);
  ASSERT_TRUE(game.client.commands.empty());
  const SceneReport scene = game.client.session.Report();
  EXPECT_TRUE(scene.regimes.empty());
  EXPECT_EQ(scene.total.best_arm, 0u);
  EXPECT_NEAR(*scene.total.saved_against_single_us, 0, 1e-6);
  EXPECT_NEAR(*scene.total.saved_against_reference_us, 50'000, 10'000);
  EXPECT_NEAR(*scene.total.centre.object_count, 2'000, 1);
}

// A drift of all costs changes what earlier frames would cost now, but not what they saved.
TEST(Report, ADriftOfAllCostsIsNoSaving) {
  ChangingGame game;
  for (int tick = 0; tick < 200; ++tick) {
    std::vector<double> costs_us = kConstantUs;
    for (double& cost_us : costs_us) cost_us *= 1 + 0.005 * tick;
    game.Play(costs_us, DescriptorOf(0.1F), 1);
  }
  ASSERT_TRUE(game.client.commands.empty());
  EXPECT_NEAR(*game.client.session.Report().total.saved_against_single_us, 0, 1e-6);
}

TEST(Report, ForgetsTheFramesOfARegimeWhosePlaceAnotherOneTakes) {
  ChangingGame game;
  float speed = 1e-4F;
  for (int regime = 0; regime < 6; ++regime, speed *= 10)
    game.Play(kMovingUs, DescriptorOf(speed), 20);
  const SceneReport scene = game.client.session.Report();
  ASSERT_EQ(scene.regimes.size(), 4u);
  for (const RegimeReport& regime : scene.regimes) EXPECT_NEAR(regime.frame_share, 1.0 / 6, 0.05);
}

TEST(Report, HasTheTimeAndTheNumberOfSwitches) {
  ChangingGame game;
  game.Play(kConstantUs, DescriptorOf(0.1F), 30);
  EXPECT_EQ(game.client.session.active_since_ns(), 0);
  EXPECT_EQ(game.client.session.RecentSwitchCount(game.client.now_ns), 0u);
  PlayResting(game, 30);
  ASSERT_FALSE(game.client.commands.empty());
  const int64_t since_ns = game.client.session.active_since_ns();
  EXPECT_GT(since_ns, 30 * kSecond);
  EXPECT_LT(since_ns, 40 * kSecond);
  EXPECT_EQ(game.client.session.RecentSwitchCount(since_ns), game.client.commands.size());
  EXPECT_EQ(game.client.session.RecentSwitchCount(since_ns + 60 * kSecond), 0u);
}

TEST(Report, OfThePaperHasOneRegimeWithoutCosts) {
  SessionSetup setup = PlainSetup(2);
  ChangingGame game(setup);
  game.saved_us.resize(2);
  game.Play({10'000, 14'000}, DescriptorOf(0.1F), 20);
  game.Play({10'000, 14'000}, DescriptorOf(0.001F), 20);
  const SceneReport scene = game.client.session.Report();
  EXPECT_TRUE(scene.regimes.empty());
  ASSERT_EQ(scene.total.arms.size(), 2u);
  EXPECT_EQ(scene.total.best_arm, game.client.session.diagnosis().leader);
  EXPECT_FALSE(scene.total.arms[0].cost);
  EXPECT_GT(*scene.total.ran_us, 9'999);
}

}  // namespace
}  // namespace sweepstake::decision
