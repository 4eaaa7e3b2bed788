// Tests the virtual game of replay, on traces with known numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "engine_client/decider/policy/log_cost.h"
#include "tests/laboratory/replay/replay_study.h"
#include "tests/laboratory/tests/replay/replay_fixtures.h"

namespace sweepstake::cli {
namespace {

using testing::Each;
using testing::HasSubstr;

constexpr double kMs = 1e6;

// Returns a trace in whose first half the first arm takes a third of the second arm's time, and in
// whose second half vice versa.
SyntheticTrace TwoRegimes() {
  SyntheticTrace trace;
  trace.frame_count = 6400;
  trace.detection_ns = [](uint32_t frame, uint32_t arm) {
    return (frame < 3200) == (arm == 0) ? 10 : 30;
  };
  trace.slowdown = [](uint32_t k) { return k == 0 ? 4.0 : 1.0; };
  return trace;
}

ReplaySetup SetupOf(const std::string& policy, uint64_t seed) {
  ReplaySetup setup;
  setup.seed = seed;
  setup.options.policy = policy;
  return setup;
}

StudyOptions StudyOf(std::vector<std::string> words, const std::vector<std::string>& arms) {
  StudyOptions options;
  options.players = *ReplayPlayers(words, arms);
  options.seed_count = 4;
  return options;
}

std::vector<StudyRow> Study(const SyntheticTrace& trace, const StudyOptions& options,
                            const GameOptions& game = {}) {
  const StudyScene scenes[] = {{"a", SceneOf(trace, game)}};
  return RunStudy(scenes, options, [](uint64_t, uint64_t) {});
}

TEST(ReplayScene, ScalesTheBestArmsMeanFrameToWhatWasAskedFor) {
  const ReplayScene scene = SceneOf(TwiceAsSlow(), {.other_work_ns = 4'000'000});
  EXPECT_EQ(scene.frame_count(), 90'000U);
  EXPECT_DOUBLE_EQ(scene.detection_ns(0, 0), 6 * kMs);
  EXPECT_DOUBLE_EQ(scene.detection_ns(0, 1), 12 * kMs);
}

TEST(ReplayScene, RefusesGamesThatCannotBe) {
  const CostTrace trace = MakeTrace(TwiceAsSlow());
  const auto message = [&](const GameOptions& options) {
    return ReplayScene::Create(trace, options).status().message();
  };
  EXPECT_THAT(message({.other_work_ns = 10'000'000}), HasSubstr("the other work"));
  EXPECT_THAT(message({.run_ns = 1'000'000}), HasSubstr("--run"));
  EXPECT_THAT(message({.frame_ns = 1'000}), HasSubstr("make --run shorter"));
}

TEST(ReplayScene, TheControlsRegretIsItsExcessOverItsTwin) {
  CostTrace trace = MakeTrace(TwiceAsSlow());
  for (uint64_t& ns : trace.control_ns) ns = 51'000;
  EXPECT_NEAR(ReplayScene::Create(trace, {})->control_regret(), 0.02, 1e-12);
}

TEST(ReplayScene, AFreshStructureIsComparedWithTheRunningOneAroundItsFrame) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  const auto slowdown = scene.slowdown(0, 1);
  ASSERT_EQ(slowdown.size(), 8U);
  EXPECT_NEAR(slowdown[0], 4, 1e-9);
  EXPECT_NEAR(slowdown[2], 1, 1e-9);
  for (size_t k = 3; k < slowdown.size(); ++k) EXPECT_NEAR(slowdown[k], 1.1, 1e-9) << k;
}

TEST(ReplayScene, AFrameHasTheDescriptorThatWasSentLastAndMayHaveNone) {
  CostTrace trace = MakeTrace(TwiceAsSlow());
  SceneDescriptor later;
  later.object_count = 2000;
  trace.descriptors.push_back({.frame = 32, .descriptor = later});
  const auto scene = ReplayScene::Create(trace, {});
  EXPECT_EQ(scene->descriptor(31)->object_count, 1000);
  EXPECT_EQ(scene->descriptor(32)->object_count, 2000);
  EXPECT_FALSE(decision::IsMeasured(scene->descriptor(32)->speed_mean)) << "was not measured";
  trace.descriptors.clear();
  EXPECT_EQ(ReplayScene::Create(trace, {})->descriptor(0), nullptr);
}

SyntheticTrace OfFrames(uint32_t frame_count) {
  SyntheticTrace trace = TwiceAsSlow();
  trace.frame_count = frame_count;
  return trace;
}

TEST(FrameOrder, ShowsEveryTraceFrameEquallyOftenWhereverItStarts) {
  const ReplayScene scene = SceneOf(OfFrames(256), {.run_ns = 256'000'000'000});
  for (const uint32_t offset : {0U, 16U, 255U}) {
    FrameOrder order(scene, offset);
    std::map<uint32_t, int> shown;
    for (uint32_t frame = 0; frame < scene.frame_count(); ++frame) ++shown[order.Next()];
    EXPECT_EQ(shown.size(), 256U);
    for (const auto& [frame, count] : shown) EXPECT_NEAR(count, 100, 2) << frame;
  }
}

TEST(FrameOrder, AWindowMovesThroughTheTraceOncePerPass) {
  const ReplayScene scene =
      SceneOf(OfFrames(1000), {.run_ns = 20'000'000'000, .pass_ns = 10'000'000'000});
  FrameOrder order(scene, 0);
  for (uint32_t frame = 0; frame < scene.frame_count(); ++frame) {
    EXPECT_EQ(order.Next(), (frame + frame % ReplayScene::kWindowFrameCount) % 1000) << frame;
  }
}

TEST(FixedCosts, AddUpToTheRunOnTheBestArm) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  const FixedCosts costs(scene, 1);
  EXPECT_NEAR(costs.TotalsFrom(0)[0], 900e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(0)[1], 1800e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(89'000)[0], 10e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(90'000)[0], 0, 1);
}

// Returns the cost of a sequence of arms, given by the bits of `arms`, with cold switches.
double CostOf(const ReplayScene& scene, uint64_t seed, uint32_t arms) {
  FrameOrder order(scene, OffsetOfSeed(scene, seed));
  std::vector<uint32_t> shown(scene.frame_count());
  for (uint32_t& frame : shown) frame = order.Next();
  double cost_ns = 0;
  for (uint32_t g = 0; g < shown.size(); ++g) {
    const uint32_t arm = arms >> g & 1;
    cost_ns += scene.detection_ns(shown[g], arm);
    if (g == 0 || arm == (arms >> (g - 1) & 1)) continue;
    const auto slowdown = scene.slowdown(shown[g], arm);
    for (uint32_t k = 0; k < slowdown.size() && g + k < shown.size(); ++k) {
      cost_ns += scene.detection_ns(shown[g + k], arm) * (slowdown[k] - 1);
    }
  }
  return cost_ns;
}

TEST(Oracle, IsTheCheapestOfAllSequencesThatPayForTheirSwitches) {
  SyntheticTrace trace;
  trace.frame_count = 12;
  trace.burst_frame_count = 2;
  trace.burst_interval = 4;
  trace.detection_ns = [](uint32_t frame, uint32_t arm) {
    constexpr uint64_t kNs[3][2] = {{1'000, 3'000}, {1'700, 1'200}, {2'000, 900}};
    return kNs[frame / 4][arm];
  };
  trace.slowdown = [](uint32_t k) { return k == 0 ? 2.5 : 1.0; };
  const ReplayScene scene = SceneOf(trace, {.run_ns = 120'000'000});
  double least_ns = 1e18;
  uint32_t best = 0;
  for (uint32_t arms = 0; arms < 1U << 12; ++arms) {
    const double cost_ns = CostOf(scene, 1, arms);
    if (cost_ns < least_ns) best = arms;
    least_ns = std::min(least_ns, cost_ns);
  }
  const auto oracle = FixedCosts(scene, 1).Oracle(10'000'000, /*warm=*/false);
  EXPECT_NEAR(oracle.regime_ns, least_ns, 1);
  EXPECT_GT(oracle.switch_count, 0U) << "a sequence of one arm proves nothing: " << best;
  EXPECT_LT(oracle.frame_ns, oracle.regime_ns);
}

uint32_t WarmSwitches(const SyntheticTrace& trace) {
  const ReplayScene scene = SceneOf(trace);
  return FixedCosts(scene, 1).Oracle(2'000'000'000, /*warm=*/true).switch_count;
}

TEST(Oracle, AWarmSwitchCostsTheLastFrameOfItsWarmUp) {
  SyntheticTrace trace = TwoRegimes();
  trace.slowdown = [](uint32_t k) { return k < 3 ? 1e6 : 2.0; };
  EXPECT_GE(WarmSwitches(trace), 1U);
  trace.slowdown = [](uint32_t) { return 1e6; };
  EXPECT_EQ(WarmSwitches(trace), 0U);
}

TEST(Oracle, StaysWhereSwitchingCostsMoreThanItSaves) {
  SyntheticTrace trace = TwoRegimes();
  trace.slowdown = [](uint32_t) { return 1e6; };
  const ReplayScene scene = SceneOf(trace);
  const auto oracle = FixedCosts(scene, 1).Oracle(2'000'000'000, /*warm=*/false);
  EXPECT_EQ(oracle.switch_count, 0U);
  EXPECT_NEAR(oracle.regime_ns, 900e9, 2e9);
}

TEST(Replay, AColdSwitchIsChargedOnce) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  // The game with seed 1 starts on KDTree. The first descriptor comes after 64 frames of 20 ms. The
  // second tick is at 4 s, after 200 frames. The next frame builds AxisSweep in 40 ms, and five
  // more frames take 11 ms each.
  ReplaySetup setup = SetupOf("thresholds", 1);
  const ReplayResult result = Replay(scene, setup);
  EXPECT_NEAR(static_cast<double>(result.total_ns), 900e9 + 200 * 10 * kMs + 30 * kMs + 5 * kMs,
              1e6);
  EXPECT_EQ(result.switch_counts[static_cast<size_t>(SwitchReason::kPolicy)], 1U);
  EXPECT_EQ(result.first_active_ns[0], 4'000'000'000);
  EXPECT_EQ(result.dominant_arm(), 0U);
  // The session counts the switch as executed only when the batch with its first frame arrives,
  // which is 130 ms later.
  EXPECT_NEAR(result.active_share(), 1 - 4.165 / 902.035, 1e-4);
}

TEST(Replay, AWarmSwitchWaitsForTheLaneAndCostsItsLastFrame) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplaySetup setup = SetupOf("thresholds", 1);
  setup.shadow_lane = true;
  const ReplayResult result = Replay(scene, setup);
  // The preparation builds for 40 ms and then runs frames of 10, 10 and 11 ms. During the
  // preparation, the game runs four more frames of 20 ms.
  EXPECT_NEAR(static_cast<double>(result.total_ns), 900e9 + 204 * 10 * kMs + 1 * kMs, 1e6);
}

// Returns the largest switch cost that the policy's gate assumes if a build takes as long as
// `slowdown` frames.
double CostInGate(double slowdown) {
  SyntheticTrace trace = TwiceAsSlow();
  trace.slowdown = [=](uint32_t k) { return k == 0 ? slowdown : 1.0; };
  ReplaySetup setup = SetupOf("adaptive", 1);
  setup.shadow_lane = false;
  double cost_s = 0;
  setup.on_decision = [&](const decision::DecisionRecord& record) {
    if (record.gate) cost_s = std::max(cost_s, record.gate->cost_s);
  };
  Replay(SceneOf(trace), setup);
  return cost_s;
}

TEST(Replay, WhatASwitchCostReachesThePolicy) { EXPECT_GT(CostInGate(200), CostInGate(1) + 0.5); }

TEST(Replay, NoTimeIsLost) {
  const ReplayScene scene = SceneOf(TwoRegimes());
  for (const std::string policy : {"paper", "random", "adaptive"}) {
    const ReplayResult result = Replay(scene, SetupOf(policy, 3));
    const auto sum = [](const auto& values) {
      return std::accumulate(values.begin(), values.end(), uint64_t{0});
    };
    EXPECT_EQ(sum(result.active_ns), result.total_ns) << policy;
    const uint64_t before = static_cast<uint64_t>(*result.observation.start_ns);
    EXPECT_EQ(sum(result.observation.active_ns) + before, result.total_ns) << policy;
    EXPECT_LT(result.after_start_up_ns, result.total_ns) << policy;
    EXPECT_GE(result.total_ns - result.after_start_up_ns, static_cast<uint64_t>(kStartUpNs));
    EXPECT_LE(result.after_start_up_switch_count, sum(result.switch_counts)) << policy;
    if (policy == "random") {
      EXPECT_GT(result.after_start_up_switch_count, 0u);
    }
  }
}

TEST(Replay, AFrameOverTheLimitIsReportedAndFledFrom) {
  SyntheticTrace trace = TwiceAsSlow();
  trace.detection_ns = [](uint32_t, uint32_t arm) { return arm == 0 ? 10'000 : 6'000'000; };
  const ReplayResult result = Replay(SceneOf(trace), SetupOf("paper", 1));
  EXPECT_GE(result.bail_out_count, 1U);
  EXPECT_GE(result.switch_counts[static_cast<size_t>(SwitchReason::kBailOut)], 1U);
  EXPECT_EQ(result.active_ns[1] % 6'000'000'000, 0U) << "a build of 24 s or frames of 6 s";
}

TEST(Replay, TheLaneKeepsToItsBudgetAndIsThereForThosePoliciesThatLearnFromIt) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  EXPECT_EQ(Replay(scene, SetupOf("paper", 1)).shadow_visit_count, 0U);
  const ReplayResult result = Replay(scene, SetupOf("adaptive", 1));
  EXPECT_GT(result.shadow_visit_count, 100U);
  const double share = static_cast<double>(result.shadow_ns) / static_cast<double>(result.total_ns);
  EXPECT_NEAR(share, 0.15, 0.01);
  ReplaySetup without = SetupOf("adaptive", 1);
  without.shadow_lane = false;
  EXPECT_EQ(Replay(scene, without).shadow_visit_count, 0U);
}

TEST(RunStudy, FixedArmsAndTheOracleHaveTheRegretThatTheTraceSays) {
  const std::vector<std::string> arms = {"AxisSweep", "KDTree"};
  const auto rows = Study(TwiceAsSlow(), StudyOf({"fixed", "oracle", "thresholds"}, arms));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_NEAR(rows[0].regret_best_fixed, 0, 1e-12);
  EXPECT_NEAR(rows[1].regret_best_fixed, 1, 1e-12);
  EXPECT_NEAR(*rows[1].regret_after_start_up, 1, 1e-12);
  EXPECT_NEAR(rows[2].regret_best_fixed, 0, 1e-12);
  // Two of the four seeds start on the slow arm. The test AColdSwitchIsChargedOnce explains the
  // cost.
  EXPECT_NEAR(rows[3].regret_best_fixed, 2.035 / 900 / 2, 1e-8);
  EXPECT_NEAR(*rows[3].regret_after_start_up, 0, 1e-9);
  EXPECT_EQ(rows[3].bail_outs, 0.0);
  EXPECT_FALSE(rows[3].headroom_captured);
}

TEST(RunStudy, MillisecondsAreThoseOfTheTraceWithoutOtherWork) {
  const auto rows =
      Study(TwiceAsSlow(), StudyOf({"fixed:KDTree", "paper", "adaptive"}, {"AxisSweep", "KDTree"}),
            {.other_work_ns = 4'000'000});
  const FrameMs& slow = rows[0].ms;
  EXPECT_NEAR(slow.detection, 0.1, 1e-9);
  EXPECT_NEAR(slow.best, 0.05, 1e-9);
  EXPECT_NEAR(slow.median, 0.075, 1e-9);
  EXPECT_NEAR(slow.worst, 0.1, 1e-9);
  EXPECT_NEAR(slow.regret_ratio(), 1, 1e-9);
  EXPECT_NEAR(rows[0].regret_best_fixed, 0.6, 1e-9);  // regret of whole frames, other work included
  EXPECT_EQ(slow.lane, 0);
  EXPECT_EQ(rows[0].paper_ms, rows[1].ms.detection);
  // The lane works for a share of the frames' time; see the test of its budget.
  EXPECT_NEAR(rows[2].ms.lane, rows[2].shadow_share * 0.05 * 10 / 6, 1e-4);
  EXPECT_GT(rows[2].ms.lane, 0.001);
}

TEST(RunStudy, WhatAPolicySaysIsComparedWithTheFramesSinceTheDecisionBefore) {
  const auto rows = Study(TwiceAsSlow(), StudyOf({"adaptive", "fixed:A"}, {"A", "B"}));
  const auto& bins = rows[0].reliability.bins();
  EXPECT_GT(rows[0].reliability.decision_count(), 4 * 440U);
  EXPECT_GT(bins.back().decision_count, 4 * 400U);
  EXPECT_EQ(bins.back().best_count, bins.back().decision_count);
  EXPECT_EQ(rows[1].reliability.decision_count(), 0U);
}

// The arms change places in the middle of the trace. The old leader is wrong from then on, until
// the lane has measured the change.
TEST(RunStudy, ALeaderThatIsNotTheFastestArmAnyMoreIsWrong) {
  const auto rows = Study(TwoRegimes(), StudyOf({"adaptive"}, {"A", "B"}));
  uint64_t wrong = 0;
  for (const ReliabilityBin& bin : rows[0].reliability.bins())
    wrong += bin.decision_count - bin.best_count;
  EXPECT_GE(wrong, 4U);
  EXPECT_LE(wrong, 4 * 2 * 10U);
}

TEST(Reliability, AProbabilityIsInTheRangeThatBeginsWithIt) {
  Reliability reliability;
  for (const double probability : {0.0, 0.5, 0.79, 0.8, 0.99, 1.0}) reliability.Add(probability, 0);
  std::vector<uint64_t> counts;
  for (const ReliabilityBin& bin : reliability.bins()) counts.push_back(bin.decision_count);
  EXPECT_EQ(counts, (std::vector<uint64_t>{1, 1, 0, 1, 1, 0, 0, 2}));
}

TEST(Reliability, ItsErrorIsTheMeanDistanceOfTheRanges) {
  Reliability reliability;
  EXPECT_EQ(reliability.error(), 0);
  reliability.Add(0.75, 0);
  reliability.Add(0.75, 0);
  Reliability other;
  other.Add(0.95, 0.01);
  other.Add(0.55, 0.005);
  reliability += other;
  EXPECT_DOUBLE_EQ(reliability.error(), (2 * 0.25 + 0.95 + 0.55) / 4);
  EXPECT_EQ(reliability.bins()[1].tie_count, 1U);
  EXPECT_EQ(reliability.bins()[1].best_count, 0U);
}

TEST(RunStudy, OfAGameThatEndsWithItsStartThereIsNoRegretAfterIt) {
  const StudyOptions options = StudyOf({"fixed", "paper", "oracle"}, {"AxisSweep", "KDTree"});
  for (const StudyRow& row : Study(TwiceAsSlow(), options, {.run_ns = kStartUpNs / 2})) {
    EXPECT_FALSE(row.regret_after_start_up) << row.player;
    EXPECT_FALSE(row.after_start_up_ci95) << row.player;
  }
}

TEST(RunStudy, TheOracleCapturesAllOfItsHeadroom) {
  const auto rows = Study(TwoRegimes(), StudyOf({"oracle", "fixed:A"}, {"A", "B"}));
  EXPECT_NEAR(rows[0].headroom, 0.5, 0.01);
  EXPECT_NEAR(*rows[0].headroom_captured, 1, 1e-9);
  EXPECT_LT(*rows[1].headroom_captured, 0.02);
}

TEST(RunStudy, TheNumberOfThreadsChangesNothing) {
  StudyOptions options = StudyOf({"paper", "adaptive", "random", "fixed"}, {"A", "B"});
  const GameOptions game{.run_ns = 120'000'000'000};
  const auto alone = Study(TwoRegimes(), options, game);
  options.thread_count = 2;
  const auto together = Study(TwoRegimes(), options, game);
  ASSERT_EQ(alone.size(), together.size());
  for (size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(alone[i].games, together[i].games) << i;
}

TEST(RunStudy, ComparesWithThePaperSeedBySeed) {
  const auto rows = Study(TwiceAsSlow(), StudyOf({"thresholds", "paper"}, {"AxisSweep", "KDTree"}));
  ASSERT_TRUE(rows[0].against_paper);
  EXPECT_NEAR(rows[0].against_paper->difference,
              rows[0].regret_best_fixed - rows[1].regret_best_fixed, 1e-12);
  EXPECT_LE(rows[0].against_paper->ci95.low, rows[0].against_paper->difference);
  EXPECT_GE(rows[0].against_paper->ci95.high, rows[0].against_paper->difference);
  EXPECT_NEAR(rows[1].against_paper->difference, 0, 1e-12);
}

TEST(RunStudy, WrongPriorsAreTheRightOnesWithTheArmsRankingReversed) {
  StudyOptions options = StudyOf({"paper"}, {"AxisSweep", "KDTree"});
  const double none = Study(TwiceAsSlow(), options)[0].regret_best_fixed;
  options.priors = ReplayPriors::kRight;
  const double right = Study(TwiceAsSlow(), options)[0].regret_best_fixed;
  options.priors = ReplayPriors::kWrong;
  const double wrong = Study(TwiceAsSlow(), options)[0].regret_best_fixed;
  EXPECT_LT(right, none);
  EXPECT_LT(none, wrong);
}

TEST(RunStudy, TheFirstChoiceIsThatOfTheFirstDecision) {
  StudyOptions options = StudyOf({"adaptive", "fixed:KDTree"}, {"AxisSweep", "KDTree"});
  options.seed_count = 3;  // the game with the second seed starts on the fast arm
  const auto first_right = [&](ReplayPriors priors, double right) {
    options.priors = priors;
    const auto rows = Study(TwiceAsSlow(), options);
    EXPECT_DOUBLE_EQ(rows[0].first_right.value(), right);
    EXPECT_FALSE(rows[1].first_right) << "no policy chooses";
    std::vector<double> result;
    for (const StudyGame& game : rows[0].games) result.push_back(*game.first_right);
    return result;
  };
  EXPECT_EQ(first_right(ReplayPriors::kNone, 1.0 / 3), (std::vector<double>{0, 1, 0}))
      << "they stay";
  EXPECT_EQ(first_right(ReplayPriors::kRight, 2.0 / 3), (std::vector<double>{1, 0, 1}))
      << "they leave the slow arm; from the fast arm, they try the other one";
}

TEST(RunStudy, AFirstChoiceIsRightWithinATie) {
  SyntheticTrace trace = TwiceAsSlow();
  for (const auto& [slow_ns, right] : {std::pair{100'400, 1.0}, {100'600, 0.5}}) {
    trace.detection_ns = [slow_ns](uint32_t, uint32_t arm) { return arm == 0 ? 100'000 : slow_ns; };
    const auto rows = Study(trace, StudyOf({"adaptive"}, {"AxisSweep", "KDTree"}));
    EXPECT_EQ(rows[0].first_right, right) << slow_ns;
  }
}

TEST(RunStudy, TheOpeningIsTheFirstTenSeconds) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  const ReplayResult result = Replay(scene, {.options = {}, .seed = 1, .shadow_lane = false});
  EXPECT_GE(result.opening_ns, uint64_t{kOpeningNs});
  EXPECT_LE(result.opening_ns, uint64_t{kOpeningNs} + 100'000'000);
  const auto rows = Study(TwiceAsSlow(), StudyOf({"adaptive", "fixed"}, {"AxisSweep", "KDTree"}));
  EXPECT_GT(*rows[0].opening_regret, 10 * rows[0].regret_best_fixed);
  EXPECT_LT(*rows[0].opening_regret, 1) << "the slow arm all the time";
  EXPECT_FALSE(rows[1].opening_regret);
}

// Returns the evidence of 50 visits per arm, measured in a game in which `arm` is the cheaper one.
ReplayResult EvidenceThat(uint32_t arm) {
  ReplayResult result;
  std::vector<decision::ArmEvidence>& stored = result.stored[""];
  stored.resize(2);
  for (uint32_t each : {0U, 1U}) {
    const double reward = decision::RewardOf(each == arm ? std::log(100.0) : std::log(200.0));
    const decision::Increment visit = decision::LogCostIncrement(each, reward, 0.02 * 0.02);
    stored[each].lane = {50 * visit.alpha, 50 * visit.beta};
  }
  return result;
}

TEST(ServedPrior, OfANewSceneAreWhatTheOthersHaveInCommon) {
  const ReplayScene own = SceneOf(TwiceAsSlow());
  const ReplayScene other = SceneOf(TwoRegimes());
  const ReplayScene* const others[] = {&other};
  const auto priors =
      ServedPrior(ReplayPriors::kScenes, "adaptive", own, others, 1, [&](const auto& scene) {
        EXPECT_EQ(&scene, &other) << "nobody has played it";
        return EvidenceThat(1);
      }).posteriors();
  ASSERT_EQ(priors.size(), 2U);
  EXPECT_GT(priors[1].mean(), priors[0].mean());
  const auto never = [](const ReplayScene&) -> ReplayResult { throw std::logic_error("played"); };
  EXPECT_FALSE(ServedPrior(ReplayPriors::kScenes, "adaptive", own, {}, 1, never).is_known());
  EXPECT_FALSE(ServedPrior(ReplayPriors::kNone, "adaptive", own, others, 1, never).is_known());
}

TEST(ServedPrior, OfAnotherClassOfMachinesAreOfOtherCostsAndCountLess) {
  const ReplayScene own = SceneOf(TwiceAsSlow());
  const auto widths = [&](ReplayPriors kind, double& ratio) {
    const auto priors = ServedPrior(kind, "adaptive", own, {}, 1, [&](const auto& scene) {
                          ratio = scene.detection_ns(0, 1) / scene.detection_ns(0, 0);
                          return EvidenceThat(0);
                        }).posteriors();
    return decision::BeliefOf(priors.at(0)).variance;
  };
  double same = 0;
  double other = 0;
  EXPECT_LT(widths(ReplayPriors::kRight, same), widths(ReplayPriors::kClass, other));
  EXPECT_DOUBLE_EQ(same, 2);
  EXPECT_GT(std::abs(std::log(other / 2)), 0.01);
  EXPECT_LT(std::abs(std::log(other / 2)), 1);
}

TEST(RunStudy, ATraceThatIsThereTwiceTeachesItselfNothing) {
  StudyOptions options = StudyOf({"adaptive"}, {"AxisSweep", "KDTree"});
  const StudyScene twice[] = {{"a", SceneOf(TwiceAsSlow())}, {"a", SceneOf(TwiceAsSlow())}};
  const auto play = [&] { return RunStudy(twice, options, [](uint64_t, uint64_t) {})[0].games; };
  const auto none = play();
  options.priors = ReplayPriors::kScenes;
  EXPECT_EQ(play(), none);
}

}  // namespace
}  // namespace sweepstake::cli
