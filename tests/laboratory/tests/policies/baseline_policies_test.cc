// Tests each baseline against its formula, on scripted sessions in which each arm has a fixed cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/baselines.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

constexpr const char* kBaselines[] = {"paper-one-draw",    "random", "thresholds",
                                      "thresholds-fitted", "ucb1",   "epsilon-greedy",
                                      "discounted-ts",     "lin-ts"};

SessionSetup SetupOf(const std::string& policy, uint32_t arm_count = 4, uint64_t seed = 1) {
  SessionSetup setup = PlainSetup(arm_count);
  setup.options.policy = policy;
  setup.seed = seed;
  return setup;
}

// A frame of arm k takes 8 ms of other work plus 4k ms of detection, so arm 0 is the best.
class Game {
 public:
  explicit Game(const SessionSetup& setup) : client_(setup) {}

  Decision Tick() {
    client_.frame.detection_time_ns = client_.arm * uint64_t{4'000'000};
    client_.frame.frame_time_ns = 8'000'000 + client_.frame.detection_time_ns;
    return client_.RunToTick();
  }
  // Plays 15 minutes.
  const std::vector<Decision>& Run() {
    for (int i = 0; i < 450; ++i) Tick();
    return client_.log;
  }
  ScriptedClient& client() { return client_; }

 private:
  ScriptedClient client_;
};

PolicySetup PlainPolicy(const std::string& policy, std::vector<std::string> arms) {
  PolicySetup setup;
  setup.options.policy = policy;
  setup.priors.resize(arms.size());
  setup.arms = std::move(arms);
  return setup;
}

void Learn(Policy& policy, uint32_t arm, uint64_t frame_time_ns) {
  Window window;
  FrameSample frame{.frame_time_ns = frame_time_ns, .object_count = 100};
  for (int i = 0; i < 100; ++i) window.Add(frame);
  policy.LearnWindow({.arm = arm, .window = window});
}

SceneDescriptor SceneWith(float object_count, float density_ratio = 0) {
  SceneDescriptor descriptor;
  descriptor.object_count = object_count;
  descriptor.density_ratio = density_ratio;
  return descriptor;
}

TEST(Baselines, DecideTheSameFromTheSameCalls) {
  for (const char* policy : kBaselines) {
    Game one(SetupOf(policy));
    Game two(SetupOf(policy));
    one.Run();
    two.Run();
    for (size_t i = 0; i < one.client().log.size(); ++i) {
      const DecisionRecord& a = one.client().log[i].record;
      const DecisionRecord& b = two.client().log[i].record;
      ASSERT_EQ(a.candidate, b.candidate) << policy;
      ASSERT_EQ(a.draws, b.draws) << policy;
      ASSERT_EQ(a.posteriors, b.posteriors) << policy;
    }
  }
}

TEST(Baselines, LearnByThePapersReward) {
  for (const char* policy : kBaselines) {
    EXPECT_EQ(PolicyKindOf(policy, ComparedPolicies()).reward_version, 1u);
    Game game(SetupOf(policy, 1));
    Game paper(SetupOf("paper", 1));
    game.Run();
    paper.Run();
    for (size_t i = 0; i < game.client().log.size(); ++i) {
      ASSERT_EQ(game.client().log[i].record.reward, paper.client().log[i].record.reward) << policy;
    }
  }
}

TEST(Baselines, OnlyThoseThatLearnExplore) {
  for (const char* policy : kBaselines) {
    const std::string name = policy;
    EXPECT_EQ(PolicyKindOf(policy, ComparedPolicies()).explores,
              name != "random" && !name.starts_with("thresholds"))
        << policy;
  }
}

TEST(OneDraw, DrawsThePapersDrawsOnceInACooldownAndKeepsTheArmInBetween) {
  Game game(SetupOf("paper-one-draw"));
  int64_t last_ns = 0;
  int draws = 0;
  const std::vector<Decision>& log = game.Run();
  for (const auto& [record, increment, visits, regime, command] : log) {
    if (record.draws.empty()) {
      ASSERT_EQ(record.candidate, record.active_arm);
      continue;
    }
    if (draws++ > 0) {
      EXPECT_GE(record.time_ns - last_ns, 38 * kSecond);
    }
    last_ns = record.time_ns;
    for (uint32_t arm = 0; arm < 4; ++arm) {
      RandomStream stream(1, RandomPurpose::kChoice, record.decision_id, arm);
      EXPECT_EQ(record.draws[arm], DrawBeta(record.posteriors[arm], stream));
    }
  }
  EXPECT_GE(draws, 20);
  EXPECT_LE(draws, 23);
}

TEST(OneDraw, DrawsAtABailOut) {
  Game game(SetupOf("paper-one-draw"));
  for (int i = 0; i < 5; ++i) game.Tick();
  FrameSample frame{.frame_time_ns = 6'000'000'000, .detection_time_ns = 6'000'000'000};
  frame.arm = game.client().arm;
  frame.switch_epoch = game.client().epoch;
  const Decision decision = game.client().session.ObserveBailOut(frame, game.client().now_ns);
  EXPECT_EQ(decision.record.draws.size(), 4u);
}

TEST(Random, TakesEachArmAsOftenAsTheOthersWithItsPropensity) {
  std::array<int, 4> counts{};
  SessionSetup setup = SetupOf("random");
  setup.options.cooldown_ns = 0;
  setup.options.settling_ns = 0;
  Game game(setup);
  for (int i = 0; i < 4'000; ++i) {
    const Decision decision = game.Tick();
    ASSERT_EQ(decision.record.propensity, 0.25);
    ++counts[*decision.record.candidate];
  }
  // The tolerance is five standard deviations of the count.
  for (const int count : counts) EXPECT_NEAR(count, 1'000, 5 * 27.4);
}

TEST(Random, KeepsItsArmForACooldown) {
  Game game(SetupOf("random"));
  std::vector<int64_t> switches;
  for (const Decision& decision : game.Run()) {
    if (decision.command) switches.push_back(decision.record.time_ns);
  }
  ASSERT_GE(switches.size(), 10u);
  for (size_t i = 1; i < switches.size(); ++i) {
    const int64_t gap_ns = switches[i] - switches[i - 1];
    EXPECT_GE(gap_ns, 40 * kSecond);
    // The policy chooses only at multiples of the cooldown, rounded to a tick.
    EXPECT_LE(gap_ns % (40 * kSecond), 12 * kSecond);
  }
}

// Counts how often other seeds draw the candidate from the same posteriors.
double FrequencyOfDraw(const DecisionRecord& record) {
  constexpr uint64_t kSeeds = 4'000;
  double count = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::vector<double> draws;
    for (uint32_t arm = 0; arm < record.posteriors.size(); ++arm) {
      RandomStream stream(seed, RandomPurpose::kChoice, 1, arm);
      draws.push_back(DrawBeta(record.posteriors[arm], stream));
    }
    if (HighestOf(std::move(draws)).candidate == record.candidate) ++count;
  }
  return count / kSeeds;
}

TEST(ThompsonSampling, LogsTheProbabilityOfItsDraw) {
  for (const char* policy : {"paper", "paper-one-draw", "discounted-ts", "calibrated"}) {
    Game game(SetupOf(policy));
    size_t draw_count = 0;
    for (const auto& [record, increment, visits, regime, command] : game.Run()) {
      if (record.draws.empty()) {
        ASSERT_EQ(record.propensity, 1) << policy;
        continue;
      }
      const std::vector<double>& best_probability = record.diagnosis.best_probability;
      const bool is_learnt = !best_probability.empty();
      ASSERT_EQ(record.propensity, is_learnt ? best_probability[*record.candidate] : 0.25)
          << policy;
      // Five standard deviations of a frequency of 4,000 draws.
      if (++draw_count % 10 == 1) {
        EXPECT_NEAR(FrequencyOfDraw(record), record.propensity, 5 * 0.0079) << policy;
      }
    }
    EXPECT_GT(draw_count, 10U) << policy;
  }
}

TEST(ThompsonSampling, DrawsEachArmAlikeBeforeAnythingIsLearnt) {
  EXPECT_EQ(PropensityOfDraw({}, 2, 4), 0.25);
  Diagnosis diagnosis;
  diagnosis.best_probability = {1, 0};
  EXPECT_GT(PropensityOfDraw(diagnosis, 1, 2), 0) << "it was drawn against all odds";
}

TEST(LinTs, LogsTheProbabilityOfItsDraw) {
  const auto policy = MakePolicy(PlainPolicy("lin-ts", {"a", "b", "c"}), ComparedPolicies());
  Learn(*policy, 0, 10'000'000);
  constexpr int kChoices = 4'000;
  std::array<double, 3> counts{}, propensities{};
  for (int i = 0; i < kChoices; ++i) {
    ChoiceInput input;
    input.decision_id = static_cast<uint64_t>(i);
    const Choice choice = policy->Choose(input);
    counts[choice.candidate] += 1.0 / kChoices;
    propensities[choice.candidate] = choice.propensity;
  }
  for (size_t arm = 0; arm < 3; ++arm) {
    EXPECT_GT(counts[arm], 0) << "each arm was drawn";
    EXPECT_NEAR(counts[arm], propensities[arm], 5 * 0.0079);
  }
  EXPECT_GT(propensities[0], propensities[1]);
}

uint32_t RuleFor(const SceneDescriptor& scene, std::vector<std::string> arms,
                 const char* name = "thresholds") {
  const auto policy = MakePolicy(PlainPolicy(name, std::move(arms)), ComparedPolicies());
  policy->LearnDescriptor(scene, 0);
  ChoiceInput input;
  input.active_arm = 2;
  return policy->Choose(input).candidate;
}

TEST(Thresholds, FollowTheRowsOfTheRule) {
  const std::vector<std::string> arms = {"BruteForce", "Grid",  "SAP",   "AxisSweep",
                                         "DBVT",       "Tracy", "KDTree"};
  EXPECT_EQ(RuleFor(SceneWith(127, 9), arms), 0u);
  EXPECT_EQ(RuleFor(SceneWith(128), arms), 3u);
  EXPECT_EQ(RuleFor(SceneWith(2'500, 0.5), arms), 3u);
  EXPECT_EQ(RuleFor(SceneWith(2'501), arms), 6u);
  EXPECT_EQ(RuleFor(SceneWith(1'000, 0.51), arms), 6u);
}

TEST(FittedThresholds, FollowTheRowsOfTheRule) {
  const std::vector<std::string> arms = {"SAP", "DBVT", "Grid", "KDTree"};
  const auto choice = [&](float speed_mean, float static_ratio) {
    SceneDescriptor scene = SceneWith(3'000);
    scene.speed_mean = speed_mean;
    scene.static_ratio = static_ratio;
    return RuleFor(scene, arms, "thresholds-fitted");
  };
  EXPECT_EQ(choice(0.0008F, 0), 3u);
  EXPECT_EQ(choice(0.0009F, 0), 1u);
  EXPECT_EQ(choice(0.0072F, 0.99F), 0u);
  EXPECT_EQ(choice(0.1F, 0.45F), 3u);
  EXPECT_EQ(choice(-1, -1), 3u) << "no motion was measured, as while objects come and go";
  EXPECT_EQ(RuleFor({}, arms, "thresholds-fitted"), 2u) << "the active arm, before a descriptor";
}

TEST(FittedThresholds, SwitchAsSoonAsAWindowAfterSettling) {
  PolicySetup setup = PlainPolicy("thresholds-fitted", {"SAP"});
  EXPECT_EQ(MakePolicy(setup, ComparedPolicies())->cooldown_ns(), 4 * kSecond);
  setup.options.cooldown_ns = kSecond;
  EXPECT_EQ(MakePolicy(setup, ComparedPolicies())->cooldown_ns(), kSecond);
}

TEST(Thresholds, TakeTheSecondArmOfARowOrStay) {
  EXPECT_EQ(RuleFor(SceneWith(1'000), {"KDTree", "SAP", "Grid"}), 1u);
  EXPECT_EQ(RuleFor(SceneWith(9'000), {"DBVT", "SAP", "Grid"}), 0u);
  EXPECT_EQ(RuleFor(SceneWith(9'000), {"Tracy", "SAP", "Grid"}), 2u);
  EXPECT_EQ(RuleFor(SceneDescriptor(), {"KDTree", "AxisSweep", "BruteForce"}), 2u);
}

TEST(Thresholds, LeaveAnArmThatBailedOut) {
  const auto policy =
      MakePolicy(PlainPolicy("thresholds", {"KDTree", "DBVT", "SAP"}), ComparedPolicies());
  policy->LearnDescriptor(SceneWith(9'000), 0);
  EXPECT_EQ(policy->Choose({}).candidate, 0u);
  policy->LearnBailOut(0);
  EXPECT_EQ(policy->Choose({}).candidate, 1u);
}

TEST(Ucb1, ComparesMeanPlusTheConfidenceRadius) {
  Game game(SetupOf("ucb1"));
  for (const auto& [record, increment, visits, regime, command] : game.Run()) {
    double n = 0;
    for (const BetaPosterior& posterior : record.posteriors) n += posterior.evidence();
    for (size_t arm = 0; arm < 4; ++arm) {
      const BetaPosterior& posterior = record.posteriors[arm];
      EXPECT_NEAR(record.draws[arm],
                  posterior.mean() + std::sqrt(2 * std::log(n) / posterior.evidence()), 1e-12);
    }
    EXPECT_EQ(record.draws[*record.candidate],
              *std::max_element(record.draws.begin(), record.draws.end()));
  }
}

TEST(EpsilonGreedy, TakesTheHighestMeanButForOneChoiceInTen) {
  int greedy_count = 0;
  SessionSetup setup = SetupOf("epsilon-greedy");
  setup.options.cooldown_ns = 0;
  setup.options.settling_ns = 0;
  Game game(setup);
  for (int i = 0; i < 4'000; ++i) {
    const DecisionRecord record = game.Tick().record;
    uint32_t best = 0;
    for (uint32_t arm = 1; arm < 4; ++arm) {
      if (record.posteriors[arm].mean() > record.posteriors[best].mean()) best = arm;
    }
    const bool greedy = record.candidate == best;
    greedy_count += greedy ? 1 : 0;
    ASSERT_DOUBLE_EQ(record.propensity, greedy ? 0.925 : 0.025);
  }
  EXPECT_NEAR(greedy_count, 3'700, 5 * 16.7);
}

TEST(LaneArgmin, RunsWhatTheLaneFindsCheapestByMoreThanTheMargin) {
  const auto policy = MakePolicy(PlainPolicy("lane-argmin", {"a", "b", "c"}), ComparedPolicies());
  const auto visit = [&](uint32_t arm, uint64_t us) {
    const ShadowSample sample{.detection_time_ns = us * 1000, .arm = arm};
    policy->LearnShadow({&sample, 1}, 0);
  };
  const auto choice = [&](uint32_t active) {
    ChoiceInput input;
    input.active_arm = active;
    return policy->Choose(input).candidate;
  };
  EXPECT_EQ(choice(1), 1u) << "nothing is known";
  visit(1, 1000);
  EXPECT_EQ(choice(1), 1u);
  EXPECT_EQ(choice(0), 1u) << "the only arm with a visit";
  visit(2, 980);
  EXPECT_EQ(choice(1), 1u) << "within the margin";
  visit(2, 500);
  EXPECT_EQ(choice(1), 2u) << "smoothed, and clearly cheaper";
  policy->LearnBailOut(2);
  EXPECT_EQ(choice(1), 1u);
  EXPECT_EQ(choice(2), 1u) << "an arm that bailed out is not chosen again";
}

TEST(Discounted, ForgetsAllArmsByTheFactorAndMakesWholeWindowsDurable) {
  PolicySetup setup = PlainPolicy("discounted-ts", {"a", "b"});
  setup.priors[1] = {31, 11};
  const auto policy = MakePolicy(setup, ComparedPolicies());
  double seen = 0;
  for (int i = 0; i < 2'000; ++i) {
    Learn(*policy, 0, 10'000'000);
    const double decay = std::pow(DiscountedPolicy::kDiscount, i + 1);
    seen = seen * DiscountedPolicy::kDiscount + 1;
    ASSERT_NEAR(policy->posteriors()[1].alpha, 1 + 30 * decay, 1e-9);
    ASSERT_NEAR(policy->posteriors()[1].beta, 1 + 10 * decay, 1e-9);
    ASSERT_NEAR(policy->posteriors()[0].evidence(), 2 + seen, 1e-9);
  }
  EXPECT_NEAR(policy->posteriors()[0].evidence(), 2 + 1 / (1 - DiscountedPolicy::kDiscount), 1e-6);
  Window window;
  window.Add({.frame_time_ns = 10'000'000, .object_count = 100});
  const Increment increment = policy->LearnWindow({.arm = 0, .window = window})->increment;
  EXPECT_DOUBLE_EQ(increment.alpha + increment.beta, 1);
}

TEST(Discounted, ChargesABailOutInFull) {
  const auto policy = MakePolicy(PlainPolicy("discounted-ts", {"a", "b"}), ComparedPolicies());
  policy->LearnBailOut(1);
  EXPECT_EQ(policy->posteriors()[1], (BetaPosterior{1, 11}));
}

TEST(LinTs, DrawsFromThePosteriorOfTheLinearModel) {
  PolicySetup setup = PlainPolicy("lin-ts", {"a", "b"});
  setup.priors[1] = {30, 10};
  const auto policy = MakePolicy(setup, ComparedPolicies());
  ChoiceInput input;
  input.seed = 5;
  input.decision_id = 7;
  // The scene has only the constant feature, so the belief has mean μ and variance 1 / n.
  const Choice choice = policy->Choose(input);
  for (uint32_t arm = 0; arm < 2; ++arm) {
    RandomStream stream(5, RandomPurpose::kChoice, 7, arm);
    const BetaPosterior& prior = setup.priors[arm];
    EXPECT_NEAR(
        choice.draws[arm],
        prior.mean() + LinTsPolicy::kSpread * DrawNormal(stream) / std::sqrt(prior.evidence()),
        1e-12);
  }
}

TEST(LinTs, LearnsWhichArmSuitsWhichScene) {
  const auto policy = MakePolicy(PlainPolicy("lin-ts", {"a", "b"}), ComparedPolicies());
  const std::array<SceneDescriptor, 2> scenes = {SceneWith(100, 0), SceneWith(100'000, 50)};
  for (int i = 0; i < 300; ++i) {
    const uint32_t scene = (i / 2) % 2;
    const uint32_t arm = i % 2;
    policy->LearnDescriptor(scenes[scene], 0);
    Learn(*policy, arm, arm == scene ? 10'000'000 : 40'000'000);
  }
  for (uint32_t scene = 0; scene < 2; ++scene) {
    policy->LearnDescriptor(scenes[scene], 0);
    for (uint64_t id = 1; id <= 50; ++id) {
      ChoiceInput input;
      input.decision_id = id;
      EXPECT_EQ(policy->Choose(input).candidate, scene);
    }
  }
}

TEST(LinTs, CountsABailOutAsManyObservationsOfNothing) {
  const auto policy = MakePolicy(PlainPolicy("lin-ts", {"a", "b"}), ComparedPolicies());
  policy->LearnBailOut(0);
  double sum = 0;
  for (uint64_t id = 1; id <= 400; ++id) {
    ChoiceInput input;
    input.decision_id = id;
    sum += policy->Choose(input).draws[0];
  }
  EXPECT_NEAR(sum / 400, 1.0 / 12, 0.01);
}

TEST(LinTs, FeaturesStayBetweenZeroAndOne) {
  SceneDescriptor descriptor = SceneWith(3e38F, 3e38F);
  descriptor.static_ratio = 7;
  descriptor.speed_mean = -3;
  descriptor.clustering_ratio = std::nanf("");
  for (const double feature : LinTsPolicy::FeaturesOf(descriptor)) {
    EXPECT_GE(feature, 0);
    EXPECT_LE(feature, 1);
  }
}

}  // namespace
}  // namespace sweepstake::decision
