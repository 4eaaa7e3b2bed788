// The virtual game of replay, on traces whose every number is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "engine_client/cli/replay_fixed.h"
#include "engine_client/cli/replay_run.h"
#include "engine_client/cli/replay_scene.h"
#include "engine_client/cli/replay_study.h"
#include "tests/engine_client/cli/synthetic_trace.h"

namespace sweepstake::cli {
namespace {

using decision::SwitchReason;
using testing::Each;
using testing::HasSubstr;

constexpr double kMs = 1e6;

ReplayScene SceneOf(const SyntheticTrace& trace, const GameOptions& options = {}) {
  auto scene = ReplayScene::Create(MakeTrace(trace), options);
  EXPECT_TRUE(scene.ok()) << scene.status().message();
  return std::move(*scene);
}

// KDTree takes twice as long as AxisSweep, which `thresholds` prefers; a new structure's first
// frame takes four times as long as a running one's, its last one a tenth longer.
SyntheticTrace TwiceAsSlow() {
  return {.arms = {"AxisSweep", "KDTree"},
          .detection_ns = [](uint32_t, uint32_t arm) { return arm == 0 ? 50'000 : 100'000; },
          .slowdown = [](uint32_t k) { return k == 0   ? 4.0
                                              : k == 7 ? 1.1
                                                       : 1.0; }};
}

// Each arm takes a third of the other's time in one half of the trace.
SyntheticTrace TwoRegimes() {
  return {.detection_ns = [](uint32_t frame,
                             uint32_t arm) { return (frame < 32) == (arm == 0) ? 10 : 30; },
          .slowdown = [](uint32_t k) { return k == 0 ? 4.0 : 1.0; }};
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
  EXPECT_THAT(message({.other_work_ns = 10'000'000}), HasSubstr("--other-work"));
  EXPECT_THAT(message({.run_ns = 1'000'000}), HasSubstr("--run"));
  EXPECT_THAT(message({.frame_ns = 1'000}), HasSubstr("--frame"));
}

TEST(ReplayScene, TheControlsRegretIsItsExcessOverItsTwin) {
  CostTrace trace = MakeTrace(TwiceAsSlow());
  for (uint64_t& ns : trace.control_ns) ns = 51'000;
  EXPECT_NEAR(ReplayScene::Create(trace, {})->control_regret(), 0.02, 1e-12);
}

TEST(FrameOrder, ShowsEveryTraceFrameEquallyOftenWhereverItStarts) {
  const ReplayScene scene = SceneOf(TwiceAsSlow(), {.run_ns = 64'000'000'000});
  for (const uint32_t offset : {0U, 16U, 37U}) {
    FrameOrder order(scene, offset);
    std::map<uint32_t, int> shown;
    for (uint32_t frame = 0; frame < scene.frame_count(); ++frame) ++shown[order.Next()];
    EXPECT_EQ(shown.size(), 64U);
    for (const auto& [frame, count] : shown) EXPECT_NEAR(count, 100, 7) << frame;
  }
}

TEST(FrameOrder, OnePassAfterAnotherInTheTracesOrder) {
  const ReplayScene scene =
      SceneOf(TwiceAsSlow(), {.run_ns = 12'800'000'000, .pass_ns = 6'400'000'000});
  FrameOrder order(scene, 0);
  std::vector<uint32_t> clips;
  for (uint32_t frame = 0; frame < scene.frame_count(); ++frame) {
    const uint32_t clip = order.Next() / ReplayScene::kClipFrameCount;
    if (clips.empty() || clips.back() != clip) clips.push_back(clip);
  }
  EXPECT_EQ(clips, (std::vector<uint32_t>{0, 1, 2, 3, 0, 1, 2, 3}));
}

TEST(FixedCosts, AddUpToTheRunOnTheBestArm) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  const FixedCosts costs(scene, 1);
  EXPECT_NEAR(costs.TotalsFrom(0)[0], 900e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(0)[1], 1800e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(89'000)[0], 10e9, 1);
  EXPECT_NEAR(costs.TotalsFrom(90'000)[0], 0, 1);
}

TEST(Oracle, PaysForEachSwitchOnce) {
  const ReplayScene scene = SceneOf(TwoRegimes());
  const auto oracle = FixedCosts(scene, 1).Oracle(10'000'000, /*warm=*/false);
  // The best fixed arm takes 5 and 15 ms by turns, the oracle always 5, and 15 more per switch.
  EXPECT_NEAR(oracle.frame_ns, 450e9, 1e9);
  EXPECT_GE(oracle.switch_count, 1U);
  EXPECT_NEAR(oracle.regime_ns, oracle.frame_ns + oracle.switch_count * 15 * kMs, 1e3);
  const auto warm = FixedCosts(scene, 1).Oracle(10'000'000, /*warm=*/true);
  EXPECT_NEAR(warm.regime_ns, warm.frame_ns, 1e3);
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
  // Seed 1 starts on KDTree; the first descriptor comes with frame 256 of 20 ms, the tick after it
  // at 6 s = 300 frames, and the frame after that builds in 40 ms and ends its burst with 11 ms.
  ReplaySetup setup = SetupOf("thresholds", 1);
  setup.keep_timeline = true;
  const ReplayResult result = Replay(scene, setup);
  EXPECT_NEAR(static_cast<double>(result.total_ns), 900e9 + 300 * 10 * kMs + 30 * kMs + 1 * kMs,
              1e6);
  EXPECT_EQ(result.switch_counts[static_cast<size_t>(SwitchReason::kPolicy)], 1U);
  ASSERT_EQ(result.timeline.activations.size(), 1U);
  EXPECT_EQ(result.timeline.activations[0].arm, 0U);
  EXPECT_EQ(result.timeline.activations[0].time_ns, 6'000'000'000);
  EXPECT_EQ(result.first_active_ns[0], 6'000'000'000);
  EXPECT_EQ(result.dominant_arm(), 0U);
  EXPECT_NEAR(result.active_share(), 1 - 6.0 / 903.031, 1e-4);
}

TEST(Replay, AWarmSwitchWaitsForTheLaneAndCostsItsLastFrame) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplaySetup setup = SetupOf("thresholds", 1);
  setup.shadow_lane = true;
  const ReplayResult result = Replay(scene, setup);
  // Building takes 40 ms and two frames more 10 ms each: three frames of 20 ms.
  EXPECT_NEAR(static_cast<double>(result.total_ns), 900e9 + 303 * 10 * kMs + 1 * kMs, 1e6);
}

TEST(Replay, TheSwitchsCostReachesTheSession) {
  const ReplayScene scene = SceneOf(TwiceAsSlow());
  ReplaySetup setup = SetupOf("thresholds", 1);
  setup.keep_timeline = true;
  const ReplayResult result = Replay(scene, setup);
  // Reported when settled: the observation's switch has its reason, and no tick took it for lost.
  EXPECT_EQ(result.observation.switch_count(SwitchReason::kPolicy), 1U);
  EXPECT_EQ(result.timeline.decisions.size(), result.decision_count);
}

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
  EXPECT_NEAR(rows[1].regret_after_start_up, 1, 1e-12);
  EXPECT_NEAR(rows[2].regret_best_fixed, 0, 1e-12);
  // Two of the four seeds start on the slow arm, see AColdSwitchIsChargedOnce.
  EXPECT_NEAR(rows[3].regret_best_fixed, 3.031 / 900 / 2, 1e-8);
  EXPECT_NEAR(rows[3].regret_after_start_up, 0, 1e-9);
  EXPECT_EQ(rows[3].bail_outs, 0.0);
  EXPECT_FALSE(rows[3].headroom_captured);
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

TEST(ReplayPlayers, SayWhatIsValid) {
  const std::vector<std::string> arms = {"Grid", "SAP"};
  const auto message = [&](std::vector<std::string> words) {
    return ReplayPlayers(words, arms).status().message();
  };
  EXPECT_THAT(message({"pape"}), HasSubstr("use default, "));
  EXPECT_THAT(message({"pape"}), HasSubstr("fixed:ARM, oracle"));
  EXPECT_THAT(message({"fixed:Octree"}), HasSubstr("their arms are Grid, SAP"));
  const auto players = ReplayPlayers(std::vector<std::string>{"fixed", "oracle", "paper"}, arms);
  ASSERT_EQ(players->size(), 4U);
  EXPECT_EQ((*players)[1].name, "fixed:SAP");
}

}  // namespace
}  // namespace sweepstake::cli
