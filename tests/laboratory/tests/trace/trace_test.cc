// Tests how scenes are traced and summarized. No times are compared. The tests check that all
// measurements are present and in the right place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "tests/laboratory/trace/cost_trace.h"
#include "tests/laboratory/trace/trace_run.h"
#include "tests/laboratory/trace/trace_summary.h"

namespace sweepstake::cli {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

void Nothing(double) {}

// The options are filled field by field: gcc 12 warns at -O3 of a temporary that nested braces
// fill.
CostTrace MustTrace(std::string scene, uint32_t object_count, std::vector<std::string> arms,
                    uint32_t frame_count, uint32_t repeat_count) {
  TraceOptions options;
  options.scene.name = std::move(scene);
  options.scene.object_count = object_count;
  options.arms = std::move(arms);
  options.frame_count = frame_count;
  options.repeat_count = repeat_count;
  auto trace = RunTrace(options, Nothing);
  if (!trace.ok()) throw std::runtime_error(trace.status().message());
  return std::move(*trace);
}

TEST(TurnOrder, NeverPutsTheControlBesideItsTwin) {
  TurnOrder order(8, 6, 1);
  size_t before = 7;
  for (int frame = 0; frame < 2000; ++frame) {
    for (const size_t contestant : order.Next()) {
      ASSERT_FALSE(before + contestant == 13 && before != contestant) << "in frame " << frame;
      before = contestant;
    }
  }
}

TEST(TurnOrder, GivesEveryContestantEveryPlace) {
  TurnOrder order(8, 6, 2);
  std::array<std::array<int, 8>, 8> counts{};
  for (int frame = 0; frame < 4000; ++frame) {
    const std::vector<size_t>& turns = order.Next();
    for (size_t place = 0; place < 8; ++place) ++counts[turns[place]][place];
  }
  for (const auto& of_contestant : counts) {
    for (const int count : of_contestant) EXPECT_NEAR(count, 500, 150);
  }
}

TEST(TurnOrder, MakesDoWithOneArmAndItsControl) {
  TurnOrder order(2, 0, 3);
  EXPECT_THAT(order.Next(), testing::UnorderedElementsAre(0U, 1U));
}

TEST(ArmPace, MeasuresEveryArmOnEveryFrameUnlessItIsSixteenTimesAsSlowAsTheBest) {
  const uint64_t costs[] = {100, 1600, 1601};
  const ArmPace pace(costs);
  EXPECT_EQ(pace.TurnOf(0, 10), ArmTurn::kEveryFrame);
  EXPECT_EQ(pace.TurnOf(1, 10), ArmTurn::kEveryFrame);
  EXPECT_EQ(pace.TurnOf(2, 10), ArmTurn::kLastFrame);
}

TEST(ArmPace, LetsASlowArmSitOutWhenItHasHadItsShareOfTheTime) {
  const uint64_t costs[] = {100, 100'000};
  ArmPace pace(costs);
  pace.Note(1, ArmTurn::kLastFrame, 10, 100'000, 200'000);
  EXPECT_EQ(pace.TurnOf(1, 10), ArmTurn::kNone);
  pace.Note(0, ArmTurn::kEveryFrame, 10, 100, 1'799'000);
  EXPECT_EQ(pace.TurnOf(1, 10), ArmTurn::kNone);
  pace.Note(0, ArmTurn::kEveryFrame, 10, 100, 1'000);
  EXPECT_EQ(pace.TurnOf(1, 10), ArmTurn::kLastFrame);
}

TEST(ArmPace, LooksAgainWhenTheSceneHasLostAnEighthOfItsObjects) {
  const uint64_t costs[] = {100, 100'000};
  ArmPace pace(costs);
  pace.Note(1, ArmTurn::kLastFrame, 1000, 100'000, 200'000);
  EXPECT_EQ(pace.TurnOf(1, 875), ArmTurn::kNone);
  EXPECT_EQ(pace.TurnOf(1, 874), ArmTurn::kLastFrame);
  pace.Note(1, ArmTurn::kLastFrame, 874, 200, 400);
  EXPECT_EQ(pace.TurnOf(1, 874), ArmTurn::kEveryFrame) << "the arm has become fast";
}

TEST(Trace, HoldsEveryArmInEveryFrameOfASoundShape) {
  const CostTrace trace = MustTrace("suite-b", 200, {"SAP", "KDTree", "Grid"}, 130, 2);
  EXPECT_EQ(ErrorOf(trace), "");
  EXPECT_EQ(trace.scene, "suite-b");
  EXPECT_EQ(trace.frame_count, 130U);
  EXPECT_EQ(trace.repeat_count, 2U);
  ASSERT_EQ(trace.arms.size(), 3U);
  EXPECT_EQ(trace.arms[2].name, "Grid");
  EXPECT_GE(trace.arms[2].version, 1U);
  EXPECT_LT(trace.control_arm, 3U);
  EXPECT_THAT(trace.object_count, Each(200U));
  EXPECT_THAT(trace.aabb_check_count, Each(testing::Gt(0U)));
  EXPECT_THAT(trace.native_bytes, Each(testing::Gt(0U)));
  EXPECT_FALSE(trace.machine.empty());
}

TEST(Trace, HasABurstInEveryThirdBlockOfTwentyFrames) {
  const CostTrace trace = MustTrace("suite-b", 50, {"SAP", "KDTree"}, 130, 1);
  std::vector<uint32_t> first_frames;
  for (const TraceBurst& burst : trace.bursts) first_frames.push_back(burst.first_frame);
  EXPECT_THAT(first_frames, ElementsAre(0U, 60U, 120U));
  EXPECT_EQ(trace.burst_frame_count, kBurstFrames);
  // 127 frames are six blocks of 20 and a shorter last block. That last block is too short for a
  // burst.
  EXPECT_EQ(MustTrace("suite-b", 50, {"SAP"}, 127, 1).bursts.size(), 2U);
}

TEST(Trace, DescribesTheSceneWheneverADescriptorIsReady) {
  const CostTrace trace = MustTrace("nearly-resting", 300, {"DBVT"}, 520, 1);
  // From frame 64 on, there is a descriptor of the latest 64 frames after every eighth frame.
  ASSERT_EQ(trace.descriptors.size(), 1U + (520 - 64) / 8);
  for (uint32_t i = 0; i < trace.descriptors.size(); ++i) {
    EXPECT_EQ(trace.descriptors[i].frame, 64 + 8 * i);
    EXPECT_EQ(trace.descriptors[i].descriptor.object_count, 300);
  }
  EXPECT_GT(trace.descriptors.back().descriptor.speed_mean, 0);
}

TEST(Trace, ShowsTheFramesAfterTheWarmUp) {
  const CostTrace trace = MustTrace("spawning", 640, {"KDTree"}, 40, 1);
  // 640 objects lose ten per step for 32 steps.
  EXPECT_EQ(trace.object_count.front(), 640 - 10 * (kTraceWarmupFrames + 1));
  EXPECT_EQ(trace.object_count[11], 320U);
  EXPECT_EQ(trace.object_count[12], 330U);
}

TEST(Trace, SaysThatAScenesObjectsAreTooMany) {
  TraceOptions options;
  options.scene = {"brownian", kMaxTracedObjects + 1, 1};
  options.arms = {"KDTree"};
  const auto trace = RunTrace(options, Nothing);
  ASSERT_FALSE(trace.ok());
  EXPECT_EQ(trace.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(trace.status().message(), HasSubstr("at most 100000 objects"));
}

// Returns a trace from a plan that declares BruteForce as very slow. BruteForce is measured
// sparsely until its real time is known.
CostTrace PassWithASlowArm(uint32_t control_arm) {
  TracePlan plan;
  plan.arms = {"KDTree", "BruteForce"};
  plan.control_arm = control_arm;
  plan.frame_ns = {1, 1'000'000};
  plan.frame_count = 60;
  const auto scene = std::move(*OpenScene({"suite-b", 100, 1}));
  return std::move(*RunTracePass(*scene, plan, [](uint32_t) {}));
}

TEST(TracePass, HoldsTheTimeOfASlowArmAndSaysSo) {
  const CostTrace trace = PassWithASlowArm(0);
  for (uint32_t frame = 0; frame < 20; ++frame) {
    EXPECT_EQ(trace.held[2 * frame], 0) << frame;
    EXPECT_EQ(trace.held[2 * frame + 1], frame < 19 ? 1 : 0) << frame;
    EXPECT_EQ(trace.detection(frame, 1), trace.detection(19, 1)) << frame;
  }
  const auto burst = std::span(trace.bursts[0].detection_ns).subspan(kBurstFrames);
  for (size_t k = 2; k < kBurstFrames; ++k) EXPECT_EQ(burst[k], burst[1]);
}

TEST(TracePass, MeasuresTheControlsTwinOnEveryFrame) {
  const CostTrace trace = PassWithASlowArm(1);
  EXPECT_THAT(trace.held, Each(0));
  EXPECT_EQ(ErrorOf(trace), "");
}

// Returns a trace of two arms with 40 frames and a burst. A frame of the first arm takes 10 ms,
// later 30 ms; a frame of the second arm always takes 20 ms.
CostTrace TwoArmTrace() {
  CostTrace trace;
  trace.scene = "made-up";
  trace.arms = {{"SAP", 1}, {"KDTree", 1}};
  trace.frame_count = 40;
  trace.control_arm = 1;
  trace.burst_frame_count = 2;
  for (uint32_t frame = 0; frame < 40; ++frame) {
    trace.object_count.push_back(10 + frame);
    trace.pair_count.push_back(frame);
    trace.step_ns.push_back(1);
    trace.control_ns.push_back(frame < 20 ? 21'000'000 : 20'000'000);
    trace.detection_ns.push_back(frame < 20 ? 10'000'000 : 30'000'000);
    trace.detection_ns.push_back(20'000'000);
  }
  trace.aabb_check_count.resize(80);
  trace.native_bytes.resize(80);
  trace.held.resize(80);
  trace.held[3] = 1;
  trace.bursts = {{0, {40'000'000, 1, 50'000'000, 1}}};
  return trace;
}

TEST(Trace, TakesTheSecondOfFiveRunsAndTheLeastOfFewerAndHoldsWhatNoRunMeasured) {
  std::vector<CostTrace> runs(5, TwoArmTrace());
  for (uint64_t run = 0; run < 5; ++run) {
    runs[run].detection_ns[7] = 50 - 10 * run;
    runs[run].control_ns[2] = 100 + run;
    runs[run].step_ns[3] = 200 - run;
    runs[run].bursts[0].detection_ns[1] = 300 + run;
    runs[run].held[3] = run == 4 ? 0 : 1;
    runs[run].held[5] = 1;
  }
  const CostTrace of_five = MergeRuns(runs);
  EXPECT_EQ(of_five.detection_ns[7], 20U);
  EXPECT_EQ(of_five.control_ns[2], 101U);
  EXPECT_EQ(of_five.step_ns[3], 197U);
  EXPECT_EQ(of_five.bursts[0].detection_ns[1], 301U);
  EXPECT_EQ(of_five.held[3], 0);
  EXPECT_EQ(of_five.held[5], 1);
  EXPECT_EQ(MergeRuns({runs[0], runs[1], runs[2]}).detection_ns[7], 30U);
}

TEST(TraceSummary, NamesTheBestFixedArmAndWhatTheOracleWouldSave) {
  const TraceSummary summary = SummarizeTrace(TwoArmTrace());
  EXPECT_DOUBLE_EQ(summary.arms[0].ms_mean, 20);
  EXPECT_DOUBLE_EQ(summary.arms[1].ms_p99, 20);
  EXPECT_DOUBLE_EQ(summary.arms[0].ms_p99, 30);
  EXPECT_DOUBLE_EQ(summary.arms[0].best_ratio, 0.5);
  EXPECT_DOUBLE_EQ(summary.arms[1].best_ratio, 0.5);
  EXPECT_DOUBLE_EQ(summary.arms[1].held_ratio, 1.0 / 40);
  EXPECT_DOUBLE_EQ(summary.arms[1].build_ms, 50);
  EXPECT_DOUBLE_EQ(summary.window_headroom, 1 - 15.0 / 20);
  EXPECT_DOUBLE_EQ(summary.frame_headroom, 1 - 15.0 / 20);
  EXPECT_EQ(summary.object_count_min, 10U);
  EXPECT_EQ(summary.object_count_max, 49U);
  EXPECT_DOUBLE_EQ(summary.pair_count_mean, 19.5);
}

TEST(TraceSummary, GivesTheControlsRatioWithAnIntervalFromItsSpread) {
  const TraceSummary summary = SummarizeTrace(TwoArmTrace());
  EXPECT_DOUBLE_EQ(summary.control_ratio, 820.0 / 800);
  // The control takes 420 ms in the first window and 400 ms in the second one; its arm takes 400 ms
  // in each. The residuals are ±10, and the standard error is 20 ÷ 800.
  EXPECT_NEAR(summary.control_high - summary.control_ratio, 1.96 * 20 / 800, 1e-9);
  EXPECT_FALSE(summary.ControlIsFair());
  CostTrace fair = TwoArmTrace();
  for (uint64_t& ns : fair.control_ns) ns = 20'050'000;
  EXPECT_TRUE(SummarizeTrace(fair).ControlIsFair());
}

TEST(TraceSummary, WorksOnATraceOfOneWindow) {
  CostTrace trace = TwoArmTrace();
  trace.frame_count = 10;
  for (auto* column : {&trace.object_count, &trace.pair_count}) column->resize(10);
  trace.control_ns.resize(10);
  trace.detection_ns.resize(20);
  const TraceSummary summary = SummarizeTrace(trace);
  EXPECT_DOUBLE_EQ(summary.control_low, summary.control_high);
  EXPECT_EQ(summary.best_arm, 0U);
  EXPECT_DOUBLE_EQ(summary.window_headroom, 0);
}

}  // namespace
}  // namespace sweepstake::cli
