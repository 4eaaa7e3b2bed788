#include "engine_client/cli/game/game_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/game/run_report.h"
#include "engine_client/cli/game/run_summary.h"
#include "engine_client/cli/game/scene_choice.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

// Counts the output of the frame path.
class CountingSink final : public FrameSink {
 public:
  void OnFrame(const FrameSample& sample) noexcept override {
    ++frame_count;
    pair_count += sample.pair_count;
  }
  void OnDescriptor(const SceneDescriptor&) noexcept override { ++descriptor_count; }
  void OnSwitch(const SwitchOutcome& outcome) noexcept override {
    executed_count += outcome.executed;
  }
  void OnModeChange(const ModeChange& change) noexcept override { obeyed_order = change.order_id; }
  void OnShadow(const ShadowSample&) noexcept override {}

  uint64_t frame_count = 0;
  uint64_t pair_count = 0;
  uint64_t descriptor_count = 0;
  uint64_t executed_count = 0;
  uint64_t obeyed_order = 0;
};

class GameRunTest : public testing::Test {
 protected:
  void Start(Mode mode, const std::string& arm) {
    scene_ = std::move(*OpenScene({"suite-g", 200, 3}));
    AdaptiveOptions options;
    options.mode = mode;
    options.initial_arm = arm;
    options.settling_ns = 1;
    options.shadow.enabled = ShadowMode::kOff;
    run_ = std::move(*GameRun::Create(options, *scene_, sink_));
  }

  uint32_t ArmIndex(const std::string& name) const {
    const auto arms = run_->adaptive().arms();
    return static_cast<uint32_t>(std::find(arms.begin(), arms.end(), name) - arms.begin());
  }

  CountingSink sink_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<GameRun> run_;
};

TEST_F(GameRunTest, ReportsTheModeChangeAfterAnOrder) {
  Start(Mode::kAi, "SAP");
  run_->adaptive().Obey({.order_id = 7, .mode = Mode::kManual, .arm = ArmIndex("Grid")});
  for (int i = 0; i < 3; ++i) run_->Frame();
  EXPECT_EQ(sink_.obeyed_order, 7U);
}

TEST_F(GameRunTest, StepsTheSceneAndPassesEachFrameToTheSink) {
  Start(Mode::kManual, "SAP");
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(run_->Frame());
  EXPECT_EQ(run_->frame_count(), 20U);
  EXPECT_EQ(scene_->frame_index(), 20U);
  EXPECT_EQ(sink_.frame_count, 20U);
  EXPECT_GT(sink_.pair_count, 0U);
  EXPECT_TRUE(run_->switches().empty());
}

TEST_F(GameRunTest, CountsTheFramesOfTheActiveArm) {
  Start(Mode::kManual, "Grid");
  for (int i = 0; i < 10; ++i) run_->Frame();
  const uint32_t grid = ArmIndex("Grid");
  for (uint32_t arm = 0; arm < run_->activities().size(); ++arm) {
    EXPECT_EQ(run_->activities()[arm].frame_count, arm == grid ? 10U : 0U) << arm;
  }
  const ArmActivity& activity = run_->activities()[grid];
  EXPECT_GT(activity.detection_ns, 0U);
  EXPECT_GE(activity.active_ns, activity.detection_ns);
}

// Checks only the lower bound, because a loaded machine can make any frame longer.
TEST_F(GameRunTest, APacedFrameTakesAtLeastItsInterval) {
  constexpr uint64_t kIntervalNs = 2'000'000;
  scene_ = std::move(*OpenScene({"two", 2, 1}));
  AdaptiveOptions options;
  options.mode = Mode::kManual;
  options.shadow.enabled = ShadowMode::kOff;
  run_ = std::move(*GameRun::Create(options, *scene_, sink_, kIntervalNs));
  for (int i = 0; i < 6; ++i) run_->Frame();
  EXPECT_GE(run_->elapsed_ns(), 5 * kIntervalNs);
  const ArmActivity& activity = run_->activities()[run_->adaptive().active_arm()];
  EXPECT_GE(activity.active_ns, 5 * kIntervalNs) << "the frame time includes the wait";
  EXPECT_LT(activity.detection_ns, activity.active_ns);
}

TEST_F(GameRunTest, TheProfileCountsTheFirstFrameAsARebuild) {
  Start(Mode::kManual, "KDTree");
  run_->Frame();
  EXPECT_GT(run_->profile().rebuild_ns, 0U);
  EXPECT_EQ(run_->profile().detection_ns, 0U);
  run_->Frame();
  EXPECT_GT(run_->profile().detection_ns, 0U);
  EXPECT_GT(run_->profile().step_ns, 0U);
}

TEST_F(GameRunTest, RecordsASwitchWithItsFirstFrameAndItsOutcome) {
  Start(Mode::kAi, "SAP");
  for (int i = 0; i < 5; ++i) run_->Frame();
  const uint32_t grid = ArmIndex("Grid");
  run_->adaptive().mailbox().Post(
      {.command_id = 1, .arm = grid, .reason = SwitchReason::kExploration});
  EXPECT_TRUE(run_->Frame());
  ASSERT_EQ(run_->switches().size(), 1U);
  const SwitchEvent& event = run_->switches().front();
  EXPECT_EQ(event.frame_index, run_->adaptive().last_sample().frame_index);
  EXPECT_EQ(event.from, ArmIndex("SAP"));
  EXPECT_EQ(event.to, grid);
  EXPECT_EQ(event.reason, SwitchReason::kExploration);
  for (int i = 0; i < 60; ++i) EXPECT_FALSE(run_->Frame());
  ASSERT_EQ(run_->outcomes().size(), 1U) << "the switch has settled";
  EXPECT_EQ(sink_.executed_count, 1U);

  const RunSummary summary = Summarize({}, *run_, {});
  ASSERT_EQ(summary.switches.size(), 1U);
  EXPECT_EQ(summary.switches[0].from, "SAP");
  EXPECT_EQ(summary.switches[0].to, "Grid");
  EXPECT_EQ(summary.switches[0].rebuild_time_ns, run_->outcomes()[0].rebuild_time_ns);
  EXPECT_EQ(summary.active_arm, "Grid");
  EXPECT_EQ(summary.frame_count, 66U);
}

TEST(OutcomeOf, OfASwitchBackAfterATrialHasItsCostsAndTheFrameThatEndedTheTrial) {
  const SwitchOutcome trial_end{
      .switch_epoch = 3, .executed = 1, .trial_detection_time_ns = 5'000, .trial_arm = 2};
  const SwitchOutcome settled{
      .switch_epoch = 3, .rebuild_time_ns = 70, .settling_cost_ns = 90, .executed = 1};
  const SwitchOutcome refused{.switch_epoch = 3, .rebuild_time_ns = 1};
  const std::vector<SwitchOutcome> outcomes{refused, trial_end, settled, refused};
  const SwitchOutcome both = OutcomeOf(outcomes, 3);
  EXPECT_EQ(both.rebuild_time_ns, 70U);
  EXPECT_EQ(both.settling_cost_ns, 90U);
  EXPECT_EQ(both.trial_detection_time_ns, 5'000U);
  EXPECT_EQ(both.trial_arm, 2U);
  EXPECT_EQ(OutcomeOf(std::span(outcomes).first(2), 3).rebuild_time_ns, 0U) << "not settled";
  EXPECT_EQ(OutcomeOf(outcomes, 4).executed, 0U);
}

TEST_F(GameRunTest, RecordsEachChangeOfTheVerdict) {
  Start(Mode::kManual, "SAP");
  run_->Frame();
  EXPECT_TRUE(run_->verdicts().empty());
  run_->adaptive().SetVerdict({Verdict::kStable, 1, 0.9});
  run_->Frame();
  run_->Frame();
  run_->adaptive().SetVerdict({Verdict::kDegraded, 1, 0.9});
  run_->Frame();
  ASSERT_EQ(run_->verdicts().size(), 2U);
  EXPECT_EQ(run_->verdicts()[0].verdict.verdict, Verdict::kStable);
  const RunSummary summary = Summarize({}, *run_, {});
  EXPECT_EQ(summary.verdict_changes[1].verdict.name, "degraded");
  EXPECT_EQ(summary.verdict_changes[1].frame_index, run_->adaptive().last_sample().frame_index);
  EXPECT_GE(summary.verdict_changes[1].time_s, summary.verdict_changes[0].time_s);
}

TEST_F(GameRunTest, ASummaryHasEachArmWithItsVersionAndBelief) {
  Start(Mode::kManual, "SAP");
  run_->Frame();
  SessionStats session;
  session.beliefs = {{run_->adaptive().arms()[0], 8, 2}};
  session.verdict = {Verdict::kTie, 1, 0.6};
  const RunSummary summary = Summarize({}, *run_, session);
  ASSERT_EQ(summary.arms.size(), run_->adaptive().arms().size());
  EXPECT_EQ(summary.arms[0].mean(), 0.8);
  EXPECT_EQ(summary.arms[1].mean(), 0.5) << "Beta(1,1) if the decider reported nothing";
  EXPECT_EQ(summary.arms[1].backend_version, run_->adaptive().arm_versions()[1]);
  EXPECT_EQ(summary.verdict.name, "tie");
  EXPECT_EQ(summary.verdict.leader_arm, run_->adaptive().arms()[1]);
}

TEST_F(GameRunTest, AnUnknownArmIsAnErrorThatListsTheArms) {
  const auto scene = std::move(*OpenScene({"two", 2, 1}));
  AdaptiveOptions options;
  options.initial_arm = "Octree";
  const auto run = GameRun::Create(options, *scene, sink_);
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.status().message().find("KDTree"), std::string::npos);
}

TEST_F(GameRunTest, TheFrameLogHasARowPerFrame) {
  Start(Mode::kManual, "SAP");
  const test_support::TemporaryDirectory folder;
  const auto log = std::move(*WholeFile::Create(folder.path() / "frames.csv"));
  WriteFrameHeader(*log);
  for (int i = 0; i < 3; ++i) {
    run_->Frame();
    WriteFrame(run_->adaptive().last_sample(), run_->adaptive(), *log);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "frames.csv"));
  ASSERT_TRUE(log->Commit().ok());
  std::ifstream file(folder.path() / "frames.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_TRUE(line.starts_with("frame,arm,switch_epoch,frame_time_ns,detection_time_ns")) << line;
  const FrameSample& last = run_->adaptive().last_sample();
  int rows = 0;
  for (std::string row; std::getline(file, row); ++rows) line = row;
  EXPECT_EQ(rows, 3);
  EXPECT_TRUE(line.starts_with(std::to_string(last.frame_index) + ",SAP," +
                               std::to_string(last.switch_epoch) + "," +
                               std::to_string(last.frame_time_ns) + ","))
      << line;
}

TEST(ScaledShadow, DividesTheIntervalOfTheSweeps) {
  const ShadowOptions plain = ScaledShadow(ShadowMode::kOn, 1);
  const ShadowOptions scaled = ScaledShadow(ShadowMode::kOn, 4);
  EXPECT_EQ(plain.sweep_interval_min_ns, ShadowOptions().sweep_interval_min_ns);
  EXPECT_EQ(scaled.sweep_interval_min_ns, plain.sweep_interval_min_ns / 4);
  EXPECT_EQ(scaled.enabled, ShadowMode::kOn);
}

TEST(Names, AreTheDocumentedOnes) {
  EXPECT_EQ(ReasonName(SwitchReason::kBailOut), "bail-out");
  EXPECT_EQ(ReasonName(SwitchReason::kManual), "manual");
  EXPECT_EQ(VerdictName(Verdict::kUnknown), "unknown");
  EXPECT_EQ(VerdictName(Verdict::kDegraded), "degraded");
}

}  // namespace
}  // namespace sweepstake::cli
