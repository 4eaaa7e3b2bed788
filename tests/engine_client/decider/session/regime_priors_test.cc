// Tests that evidence is stored per regime, and that a session starts each regime from the evidence
// of that regime.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/pooling/prior.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

SceneDescriptor DescriptorAt(double speed) {
  SceneDescriptor descriptor;
  descriptor.object_count = 1'000;
  descriptor.speed_mean = static_cast<float>(speed);
  return descriptor;
}

// A game in a scene that rests or moves. The first arm is the best one while the scene rests, and
// the second one while it moves. A session that knows only the mean costs prefers the second arm.
class GameOfTwoRegimes {
 public:
  static constexpr double kRest = 0.001, kMotion = 1;

  explicit GameOfTwoRegimes(const SessionSetup& setup) : client_(setup) {}

  static SessionSetup Setup() {
    SessionSetup setup = PlainSetup(2);
    setup.options.policy = "adaptive";
    return setup;
  }

  // Runs ticks at this speed of the scene. Returns after how many of them the arm is active.
  int TicksOn(uint32_t arm, double speed, int count) {
    int ticks = 0;
    for (int i = 0; i < count; ++i) {
      RunTick(speed);
      ticks += client_.arm == arm ? 1 : 0;
    }
    return ticks;
  }

  void Sweep(double speed) {
    for (const uint32_t arm : {0u, 1u}) {
      const ShadowSample sample{.first_frame_index = client_.frame_index,
                                .detection_time_ns = CostNs(arm, speed),
                                .arm = arm,
                                .object_count = 1'000,
                                .frame_count = 5};
      client_.session.ObserveShadow({&sample, 1});
    }
  }

  void RunTick(double speed) {
    client_.frame.detection_time_ns = CostNs(client_.arm, speed);
    client_.session.ObserveDescriptor(DescriptorAt(speed));
    client_.RunToTick();
  }

  const std::vector<Decision>& log() const { return client_.log; }

 private:
  static uint64_t CostNs(uint32_t arm, double speed) {
    if (arm == 1) return 300'000;
    return speed == kRest ? 30'000 : 6'000'000;
  }

  ScriptedClient client_;
};

// The evidence that a store has after a game, by regime, arm and kind.
class StoredGames {
 public:
  void Add(const GameOfTwoRegimes& game, const std::string& scene = "scene") {
    for (const Decision& decision : game.log()) {
      if (decision.increment) Add(*decision.increment, {}, decision.regime, scene);
      for (const Increment& increment : decision.lane_increments)
        Add(increment, kLaneName, decision.regime, scene);
    }
  }

  // Returns the setup of a new session of the scene.
  SessionSetup Setup(const std::string& scene = "scene") const {
    std::vector<ArmRecord> records;
    for (const auto& [place, evidence] : evidence_) {
      const auto& [of_scene, regime, arm] = place;
      records.push_back({.project = "game",
                         .scene = of_scene,
                         .machine_class = {},
                         .reward_version = kLogCostRewardVersion,
                         .source = "source",
                         .build = {},
                         .arm = arm,
                         .evidence = evidence,
                         .regime = regime});
    }
    SessionSetup setup = GameOfTwoRegimes::Setup();
    const Prior prior = PriorFor(records, {.project = "game",
                                           .scene = scene,
                                           .machine_class = {},
                                           .reward_version = kLogCostRewardVersion,
                                           .arms = setup.arms,
                                           .backend_versions = {1, 1},
                                           .compares_sources = true});
    setup.priors = prior.posteriors();
    setup.regime_priors = prior.regimes;
    EXPECT_EQ(Validate(setup, ShippedPolicies()), std::nullopt);
    return setup;
  }

  std::set<std::string> regimes() const {
    std::set<std::string> regimes;
    for (const auto& [place, evidence] : evidence_) regimes.insert(std::get<1>(place));
    return regimes;
  }

 private:
  void Add(const Increment& increment, std::string_view measured_by, const std::string& regime,
           const std::string& scene) {
    evidence_[{scene, regime, "arm" + std::to_string(increment.arm)}] +=
        EvidenceBy(measured_by, {.alpha = increment.alpha,
                                 .beta = increment.beta,
                                 .window_count = increment.window_count,
                                 .bail_out_count = increment.bail_out_count});
  }

  std::map<std::tuple<std::string, std::string, std::string>, ArmEvidence> evidence_;
};

// Returns what a game with a lane stores.
StoredGames PlayedGames(const std::string& scene = "scene") {
  GameOfTwoRegimes game(GameOfTwoRegimes::Setup());
  for (int phase = 0; phase < 6; ++phase) {
    for (int tick = 0; tick < 20; ++tick) {
      const double speed = phase % 2 == 0 ? GameOfTwoRegimes::kRest : GameOfTwoRegimes::kMotion;
      if (tick > 3) game.Sweep(speed);
      game.RunTick(speed);
    }
  }
  StoredGames store;
  store.Add(game, scene);
  return store;
}

TEST(RegimePriors, EvidenceIsStoredInTheRegimeOfItsFrames) {
  EXPECT_EQ(PlayedGames().regimes(), (std::set<std::string>{"9/-7/-", "9/0/-"}));
}

TEST(RegimePriors, ANewSessionStartsEachRegimeFromItsOwnEvidence) {
  const SessionSetup setup = PlayedGames().Setup();
  ASSERT_EQ(setup.regime_priors.buckets.size(), 2u);
  EXPECT_EQ(setup.regime_priors.stored_count, 2u);
  for (const bool begins_at_rest : {true, false}) {
    const double first = begins_at_rest ? GameOfTwoRegimes::kRest : GameOfTwoRegimes::kMotion;
    const double second = begins_at_rest ? GameOfTwoRegimes::kMotion : GameOfTwoRegimes::kRest;
    const uint32_t best = begins_at_rest ? 0 : 1;
    GameOfTwoRegimes game(setup);
    EXPECT_EQ(game.TicksOn(best, first, 20), 20) << begins_at_rest;
    // A regime that is new to the session is recognised by its second descriptor.
    EXPECT_GE(game.TicksOn(1 - best, second, 20), 18) << begins_at_rest;
    EXPECT_GE(game.TicksOn(best, first, 20), 19) << begins_at_rest;
  }
}

// Shows that the scene needs its priors per regime.
TEST(RegimePriors, TheMixtureOfAllRegimesChoosesTheWrongArmForLonger) {
  SessionSetup setup = PlayedGames().Setup();
  setup.regime_priors = {};
  GameOfTwoRegimes game(setup);
  const int at_rest = game.TicksOn(0, GameOfTwoRegimes::kRest, 20);
  const int in_motion = game.TicksOn(1, GameOfTwoRegimes::kMotion, 20);
  EXPECT_LT(std::min(at_rest, in_motion), 16) << "of 20; with priors per regime at least 18";
}

TEST(RegimePriors, ANewSceneStartsFromTheSameRegimesOfOtherScenes) {
  const SessionSetup setup = PlayedGames("another scene").Setup();
  ASSERT_EQ(setup.regime_priors.buckets.size(), 2u);
  EXPECT_EQ(setup.regime_priors.stored_count, 0u);
  GameOfTwoRegimes game(setup);
  EXPECT_EQ(game.TicksOn(0, GameOfTwoRegimes::kRest, 20), 20);
  EXPECT_GE(game.TicksOn(1, GameOfTwoRegimes::kMotion, 20), 18);
}

TEST(RegimePriors, TheLaneOutweighsThePriorsOfARegime) {
  SessionSetup setup = PlayedGames().Setup();
  std::vector<BetaPosterior>& priors = setup.regime_priors.posteriors;
  std::swap(priors[0], priors[1]);
  std::swap(priors[2], priors[3]);
  GameOfTwoRegimes game(setup);
  int right = 0;
  for (int tick = 0; tick < 40; ++tick) {
    const double speed = tick < 20 ? GameOfTwoRegimes::kRest : GameOfTwoRegimes::kMotion;
    if (tick % 20 > 2) game.Sweep(speed);
    right += game.TicksOn(tick < 20 ? 0 : 1, speed, 1);
  }
  EXPECT_GE(right, 26);
}

// The stored evidence of motion lacks the second arm. At rest it costs ten times the first one.
TEST(RegimePriors, AnObservedArmWithoutPriorsKeepsItsDifference) {
  std::map<bool, double> evidence;
  for (const bool was_observed : {true, false}) {
    SessionSetup setup = PlayedGames().Setup();
    ASSERT_EQ(setup.regime_priors.buckets[0], "9/0/-");
    setup.regime_priors.posteriors[1] = BetaPosterior{};
    GameOfTwoRegimes game(setup);
    for (int tick = 0; tick < 20; ++tick) {
      if (was_observed) game.Sweep(GameOfTwoRegimes::kRest);
      game.RunTick(GameOfTwoRegimes::kRest);
    }
    game.TicksOn(0, GameOfTwoRegimes::kMotion, 2);
    const std::vector<BetaPosterior>& beliefs = game.log().back().record.posteriors;
    EXPECT_NEAR(LogCostOfReward(beliefs[1].mean()) - LogCostOfReward(beliefs[0].mean()),
                std::log(10), 0.3)
        << was_observed;
    evidence[was_observed] = beliefs[1].evidence();
  }
  EXPECT_GT(evidence[true], 1.2 * evidence[false]) << "an arm that was not observed is unknown";
}

TEST(RegimePriors, ASceneHasALimitedNumberOfRegimes) {
  SessionSetup setup = PlayedGames().Setup();
  GameOfTwoRegimes game(setup);
  std::set<std::string> regimes(setup.regime_priors.buckets.begin(),
                                setup.regime_priors.buckets.end());
  for (int i = 0; i < 40; ++i) {
    game.TicksOn(0, std::exp(i - 5), 8);
  }
  bool has_other_evidence = false;
  for (const Decision& decision : game.log()) {
    if (!decision.increment) continue;
    has_other_evidence = has_other_evidence || decision.regime.empty();
    if (!decision.regime.empty()) regimes.insert(decision.regime);
  }
  EXPECT_EQ(regimes.size(), kMaxStoredRegimes);
  EXPECT_TRUE(has_other_evidence) << "evidence of a ninth regime must not enter another one";
}

TEST(RegimePriors, AreChecked) {
  SessionSetup setup = PlayedGames().Setup();
  setup.regime_priors.posteriors.pop_back();
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  setup = PlayedGames().Setup();
  setup.regime_priors.buckets[1] = setup.regime_priors.buckets[0];
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  setup.regime_priors.buckets[1] = "fast";
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
  setup = PlayedGames().Setup();
  setup.regime_priors.posteriors[1].beta = 0;
  EXPECT_TRUE(Validate(setup, ShippedPolicies()));
}

}  // namespace
}  // namespace sweepstake::decision
