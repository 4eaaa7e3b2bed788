#include "engine_client/cli/game/run_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::FileText;
using test_support::TemporaryDirectory;
using testing::HasSubstr;
using testing::Not;

constexpr uint64_t kSecond = 1'000'000'000;

// Returns a run with two arms, three frames per second of the first arm, and one switch.
RunSummary SomeSummary() {
  RunSummary summary;
  summary.setup.scene.name = "suite-b";
  summary.setup.scene.object_count = 100;
  summary.setup.scene.seed = 7;
  summary.setup.mode = "ai";
  summary.setup.decider = "embedded";
  summary.setup.priors_key = "project p";
  summary.frame_count = 40;
  summary.initial_arm = "SAP";
  summary.active_arm = "Grid";
  summary.arms = {{"SAP", 2, {"SAP", 3, 1}, {30, 10 * kSecond, 6 * kSecond}},
                  {"Grid", 5, {"Grid", 1, 7}, {10, 30 * kSecond, kSecond}}};
  summary.arms[0].belief.standing = ArmStanding{.live_window_count = 12,
                                                .lane_visit_count = 34,
                                                .effective_window_count = 5.625,
                                                .best_probability = 0.875,
                                                .cost_ratio = CostRatio{}};
  summary.arms[1].belief.standing = ArmStanding{.lane_visit_count = 3,
                                                .effective_window_count = 0.0625,
                                                .best_probability = 0.125,
                                                .cost_ratio = CostRatio{2, 1.5, 2.75}};
  summary.session.saved_us = 35'000;
  summary.session.beliefs = {summary.arms[0].belief, summary.arms[1].belief};
  summary.switches = {{12, 1.25, "SAP", "Grid", SwitchReason::kBailOut, 1000, 2000}};
  summary.verdict = {"stable", "SAP", 0.875};
  summary.verdict_changes = {{20, 2.5, {"tie", "Grid", 0.5}}};
  return summary;
}

TEST(RunSummary, SumsTheValuesOfItsArms) {
  const RunSummary summary = SomeSummary();
  EXPECT_EQ(summary.active_ns(), 40 * kSecond);
  EXPECT_EQ(summary.fps(), 1);
  EXPECT_EQ(summary.arms[0].mean(), 0.75);
  EXPECT_EQ(summary.arms[0].fps(), 3);
  EXPECT_EQ(summary.arms[0].detection_ms(), 200);
  EXPECT_EQ(summary.SwitchCount(SwitchReason::kBailOut), 1U);
  EXPECT_EQ(summary.SwitchCount(SwitchReason::kPolicy), 0U);
}

TEST(RunSummary, OfARunWithoutFramesHasNoDivisionByZero) {
  const RunSummary summary;
  EXPECT_EQ(summary.fps(), 0);
  EXPECT_EQ(summary.shadow_busy_ratio(), 0);
  EXPECT_EQ(summary.shadow_copy_ns_per_frame(), 0);
  EXPECT_EQ(ArmRow().fps(), 0);
  EXPECT_EQ(ArmRow().detection_ms(), 0);
  EXPECT_EQ(ArmRow().mean(), 0.5);
}

TEST(RunReportText, HasATableOfTheArmsAndALineForEachFact) {
  const std::string text = RunReportText(SomeSummary());
  EXPECT_THAT(text, HasSubstr("\nPosteriors learnt in suite-b with 100 objects (no priors yet"));
  EXPECT_THAT(text,
              HasSubstr("arm   cost  95_low  95_high   best  equiv  live  lane   mean  alpha  "
                        "beta  active_%  frames  detection_ms\n"));
  EXPECT_THAT(text,
              HasSubstr("SAP   1.00    1.00     1.00  0.875    5.6    12    34  0.750    3.0  "
                        " 1.0      25.0      30      200.0000\n"));
  EXPECT_THAT(text,
              HasSubstr("Grid  2.00    1.50     2.75  0.125    0.1     0     3  0.125    1.0  "
                        " 7.0      75.0      10      100.0000\n"));
  EXPECT_THAT(text, HasSubstr("equiv: the number of live windows\nthat would be as informative"));
  EXPECT_THAT(text, HasSubstr("40 frames in 40.0 s, 1 frames/s\n"));
  EXPECT_THAT(text, HasSubstr("no samples dropped\n"));
  EXPECT_THAT(text, HasSubstr("1 switch: 1 bail-out\n"));
  RunSummary tried = SomeSummary();
  tried.switches[0].trial_detection_time_ns = 3000;
  EXPECT_THAT(RunReportText(tried), HasSubstr("1 switch: 1 bail-out; 1 ended a trial\n"));
  EXPECT_THAT(text, HasSubstr("Verdict: stable: SAP is the best with probability 0.88\n"));
  EXPECT_THAT(text, Not(HasSubstr("Nothing was learnt")));
}

TEST(RunReportText, StatesHowManyFramesWereSuspended) {
  RunSummary summary = SomeSummary();
  EXPECT_THAT(RunReportText(summary), Not(HasSubstr("suspended")));
  EXPECT_EQ(RunReportJson(summary)["suspended_frames"], 0);
  summary.suspended_frame_count = 1;
  EXPECT_THAT(RunReportText(summary),
              HasSubstr("\nThe system suspended the game in 1 frame, which does not count"));
  summary.suspended_frame_count = 2;
  EXPECT_THAT(RunReportText(summary), HasSubstr("in 2 frames, which do not count as evidence\n"));
  EXPECT_EQ(RunReportJson(summary)["suspended_frames"], 2);
}

TEST(RunReportText, StatesHowManyObjectsOverlapNothing) {
  RunSummary summary = SomeSummary();
  EXPECT_THAT(RunReportText(summary), Not(HasSubstr("overlap nothing")));
  EXPECT_EQ(RunReportJson(summary)["invalid_boxes"], 0);
  summary.invalid_box_count = 1;
  EXPECT_THAT(RunReportText(summary), HasSubstr("\n1 object overlaps nothing, because its box is"));
  summary.invalid_box_count = 2;
  EXPECT_THAT(RunReportText(summary),
              HasSubstr("\n2 objects overlap nothing, because their boxes"));
  EXPECT_EQ(RunReportJson(summary)["invalid_boxes"], 2);
}

TEST(RunReportText, StatesWhyTheSessionWasLost) {
  RunSummary summary = SomeSummary();
  summary.session.connection_count = 1;
  EXPECT_THAT(RunReportText(summary), Not(HasSubstr("did not end properly")));
  summary.session.last_error = "an operator has ended this session (KICKED)";
  summary.session.dropped_frame_count = 3;
  const std::string text = RunReportText(summary);
  EXPECT_THAT(
      text,
      HasSubstr("The session did not end properly: an operator has ended this session (KICKED)\n"));
  EXPECT_THAT(text, HasSubstr("(the daemon was lost)"));
}

TEST(RunReportText, StatesThatNothingWasLearntWithAndWithoutBeliefs) {
  const char* const nothing = "Nothing was learnt yet: all posteriors are Beta(1,1)\n";
  RunSummary summary = SomeSummary();
  for (ArmRow& row : summary.arms) row.belief = {row.arm};
  summary.session.beliefs = {summary.arms[0].belief, summary.arms[1].belief};
  summary.verdict = {};
  EXPECT_THAT(RunReportText(summary), HasSubstr(nothing));
  EXPECT_THAT(RunReportText(summary), HasSubstr("Verdict: unknown\n"));
  summary.session.beliefs.clear();
  EXPECT_THAT(RunReportText(summary), HasSubstr(nothing));
  summary.arms[1].belief.beta = 1.02;  // old evidence that was discounted almost to nothing
  EXPECT_THAT(RunReportText(summary), Not(HasSubstr(nothing)));
}

TEST(RunReportText, StatesWhatToDoIfNoDaemonWasReached) {
  RunSummary summary = SomeSummary();
  summary.setup.decider = "127.0.0.1:7433";
  const char* const advice =
      "Nothing was learnt, because no daemon decided: start one with sweepstaked --listen "
      "127.0.0.1:7433, or use --embedded\n";
  const std::string text = RunReportText(summary);
  EXPECT_THAT(text, HasSubstr(advice));
  EXPECT_THAT(text, Not(HasSubstr("Posteriors learnt")));
  EXPECT_THAT(text, Not(HasSubstr("Verdict")));
  EXPECT_THAT(text, HasSubstr("40 frames in 40.0 s"));
  summary.session.connection_count = 1;
  EXPECT_THAT(RunReportText(summary), Not(HasSubstr(advice)));
}

TEST(RunReportJson, HasTheFieldsThatScriptsRead) {
  const nlohmann::ordered_json document = RunReportJson(SomeSummary());
  EXPECT_EQ(document["command"], "run");
  EXPECT_EQ(document["scene"], "suite-b");
  EXPECT_EQ(document["objects"], 100);
  EXPECT_EQ(document["seed"], 7);
  EXPECT_EQ(document["frames"], 40);
  EXPECT_EQ(document["seconds"], 40);
  EXPECT_EQ(document["active_arm"], "Grid");
  EXPECT_EQ(document["arms"][1]["arm"], "Grid");
  EXPECT_EQ(document["arms"][1]["beta"], 7);
  EXPECT_EQ(document["arms"][0]["detection_ms"], 200);
  EXPECT_EQ(document["arms"][0]["n"], 5.625);
  EXPECT_EQ(document["arms"][1]["live_windows"], 0);
  EXPECT_EQ(document["arms"][1]["lane_visits"], 3);
  EXPECT_EQ(document["arms"][1]["best_probability"], 0.125);
  EXPECT_EQ(document["arms"][1]["cost_ratio"], 2);
  EXPECT_EQ(document["arms"][1]["cost_ratio_95"], (std::vector<double>{1.5, 2.75}));
  EXPECT_EQ(document["detection_ms"], 175);
  EXPECT_EQ(document["switches_by_reason"]["bail-out"], 1);
  EXPECT_EQ(document["switches_by_reason"].size(), 4U);
  EXPECT_EQ(document["switches"][0]["to"], "Grid");
  EXPECT_EQ(document["switches"][0]["trial_detection_time_ns"], 0);
  EXPECT_EQ(document["switches"][0]["time_s"], 1.25);
  EXPECT_EQ(document["verdict"], "stable");
  EXPECT_EQ(document["leader_arm"], "SAP");
  EXPECT_EQ(document["verdict_changes"][0]["verdict"], "tie");
  EXPECT_EQ(document["verdict_changes"][0]["frame"], 20);
}

TEST(RunReportJson, ContainsTheDaemonsVersionPolicyAndSeed) {
  RunSummary summary = SomeSummary();
  EXPECT_TRUE(RunReportJson(summary)["daemon"].is_null()) << "the run had no daemon";
  summary.session.daemon_version = "1.2.3";
  summary.session.policy = "paper";
  summary.session.seed = ~uint64_t{0};
  const nlohmann::ordered_json daemon = RunReportJson(summary)["daemon"];
  EXPECT_EQ(daemon["version"], "1.2.3");
  EXPECT_EQ(daemon["policy"], "paper");
  EXPECT_EQ(daemon["seed"], "18446744073709551615");
  EXPECT_FALSE(daemon.contains("weights"));
  summary.session.rules = {.weights = RewardWeights{0.25, 0.25, 0.5, 0},
                           .decision_interval_ns = kSecond,
                           .cooldown_ns = 0,
                           .settling_ns = kSecond / 2};
  const nlohmann::ordered_json rules = RunReportJson(summary)["daemon"];
  EXPECT_EQ(rules["weights"], (std::vector<double>{0.25, 0.25, 0.5, 0}));
  EXPECT_EQ(rules["interval_s"], 1);
  EXPECT_EQ(rules["cooldown_s"], 0);
  EXPECT_EQ(rules["settling_s"], 0.5);
}

TEST(RunReportJson, OmitsAnUnknownLeader) {
  RunSummary summary = SomeSummary();
  summary.verdict = {};
  const nlohmann::ordered_json document = RunReportJson(summary);
  EXPECT_EQ(document["verdict"], "unknown");
  EXPECT_FALSE(document.contains("leader_arm"));
}

TEST(WriteRunReportCsv, WritesARowPerSwitchAndPerArm) {
  const TemporaryDirectory folder;
  ASSERT_TRUE(WriteRunReportCsv(SomeSummary(), folder.path()).ok());
  EXPECT_EQ(
      FileText(folder.path() / "switches.csv"),
      "frame,time_s,from,to,reason,rebuild_time_ns,settling_cost_ns,trial_detection_time_ns\r\n"
      "12,1.250000,SAP,Grid,bail-out,1000,2000,0\r\n");
  EXPECT_EQ(FileText(folder.path() / "posteriors.csv"),
            "arm,backend_version,alpha,beta,mean,n,active_s,frames,live_windows,lane_visits,"
            "best_probability,cost_ratio,cost_ratio_low,cost_ratio_high\r\n"
            "SAP,2,3.000000000,1.000000000,0.750000000,5.625000000,10.000000,30,12,34,"
            "0.875000000,1.000000000,1.000000000,1.000000000\r\n"
            "Grid,5,1.000000000,7.000000000,0.125000000,0.062500000,30.000000,10,0,3,"
            "0.125000000,2.000000000,1.500000000,2.750000000\r\n");
}

TEST(WriteRunReportCsv, NamesTheFileThatCannotBeWritten) {
  const Status status = WriteRunReportCsv(SomeSummary(), "/nonexistent");
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/nonexistent/switches.csv"));
}

TEST(PriorsText, StatesThePriorsOfTheRun) {
  RunSetup setup;
  SessionStats session;
  EXPECT_EQ(PriorsText(setup, session), "no priors yet");
  session.priors_unavailable = true;
  EXPECT_EQ(PriorsText(setup, session), "the daemon cannot read its priors; its log says why");
  session.priors_unavailable = false;
  session.prior_source_count = 1;
  EXPECT_EQ(PriorsText(setup, session), "starts from priors of 1 earlier session");
  session.prior_source_count = 3;
  EXPECT_EQ(PriorsText(setup, session), "starts from priors of 3 earlier sessions");
  setup.priors_file = "p.json";
  setup.priors_key = "project p";
  EXPECT_EQ(PriorsText(setup, session), "starts from priors of 3 earlier sessions");
  session.prior_source_count = 0;
  EXPECT_EQ(PriorsText(setup, session), "p.json has no priors of these backends for project p");
}

TEST(SwitchText, ContainsTheTimeTheArmsAndTheReason) {
  EXPECT_EQ(SwitchText(SomeSummary().switches[0]), "1.2 s  frame 12: SAP → Grid (bail-out)");
  EXPECT_EQ(VerdictChangeText(SomeSummary().verdict_changes[0]),
            "2.5 s  frame 20: verdict tie: Grid is the best with probability 0.50");
}

TEST(ShadowText, StatesWhyTheLaneIsOffOrWhatItCost) {
  RunSummary summary = SomeSummary();
  summary.shadow.state = ShadowState::kNoSpareCore;
  summary.shadow.cold_switch_count = 2;
  EXPECT_EQ(ShadowText(summary), "Shadow lane: off, no core to spare; 0 warm and 2 cold switches");
  summary.shadow = {.state = ShadowState::kRunning,
                    .sweep_count = 2,
                    .visit_count = 9,
                    .busy_time_ns = 4 * kSecond,
                    .copy_time_ns = 8000,
                    .slowdown_time_ns = kSecond,
                    .warm_switch_count = 1};
  EXPECT_EQ(ShadowText(summary),
            "Shadow lane: running, 9 visits in 2 sweeps, 10.0 % of its thread's time, slowed the "
            "frame thread by 2.50 %, copying took 200 ns per frame; 1 warm and 0 cold switches");
}

TEST(FrameCostText, StatesTheSavedTimeAndTheTimeOfTheLane) {
  RunSummary summary = SomeSummary();
  summary.shadow.busy_time_ns = 4 * kSecond;
  EXPECT_EQ(FrameCostText(summary),
            "Per frame: 175.0000 ms of detection, 35.0000 ms less than estimated for always SAP, "
            "the arm at the start; the shadow lane used 100.0000 ms of another core");
  EXPECT_EQ(RunReportJson(summary)["initial_arm"], "SAP");
  EXPECT_EQ(RunReportJson(summary)["saved_against_initial_us"], 35'000);
  EXPECT_EQ(RunReportJson(summary)["shadow"]["ms_per_frame"], 100);
  summary.session.saved_us = -25'000;
  EXPECT_THAT(FrameCostText(summary), HasSubstr("25.0000 ms more than estimated for always SAP"));
  summary.session.saved_us.reset();
  EXPECT_EQ(
      FrameCostText(summary),
      "Per frame: 175.0000 ms of detection; the shadow lane used 100.0000 ms of another core");
  EXPECT_TRUE(RunReportJson(summary)["saved_against_initial_us"].is_null());
  summary.shadow.busy_time_ns = 0;
  EXPECT_EQ(FrameCostText(summary), "Per frame: 175.0000 ms of detection");
}

TEST(RunReportText, HasADashForUnknownValues) {
  RunSummary summary = SomeSummary();
  summary.arms[1].belief.standing.reset();
  EXPECT_THAT(RunReportText(summary),
              HasSubstr("Grid     -       -        -      -      -     -     -"));
  EXPECT_TRUE(RunReportJson(summary)["arms"][1]["n"].is_null());
}

TEST(BeliefsText, ListsTheArmsBestFirst) {
  ArmBelief beliefs[] = {{"SAP", 1, 1}, {"Grid", 4.5, 1.5}, {"KDTree", 19.5, 4.5}};
  EXPECT_EQ(BeliefsText(beliefs), "KDTree 0.81 · Grid 0.75 · SAP 0.50");
  for (ArmBelief& belief : beliefs)
    belief.standing =
        ArmStanding{.effective_window_count = belief.alpha + belief.beta - 2, .cost_ratio = {}};
  EXPECT_EQ(BeliefsText(beliefs),
            "KDTree 0.81 (22.0 equivalent windows) · Grid 0.75 (4.0) · SAP 0.50 (0.0)");
  beliefs[1].standing->cost_ratio = {1.5, 1.25, 2};
  beliefs[2].standing->cost_ratio = CostRatio{};
  EXPECT_EQ(BeliefsText(beliefs),
            "KDTree ×1.00 (22.0 equivalent windows) · Grid ×1.50 (4.0) · SAP 0.50 (0.0)");
  EXPECT_EQ(BeliefsText({}), "");
}

TEST(DroppedText, StatesTheCauseAndTheConsequenceOfDroppedSamples) {
  SessionStats session;
  session.connection_count = 1;
  EXPECT_EQ(DroppedText(session, 10), "no samples dropped");
  session.dropped_frame_count = 3;
  EXPECT_THAT(DroppedText(session, 10), HasSubstr("3 of 10 samples"));
  EXPECT_THAT(DroppedText(session, 10), HasSubstr("(frames come faster than they are sent)"));
  EXPECT_THAT(DroppedText(session, 10), HasSubstr("the frames were not delayed"));
  session.last_error = "no connection";
  EXPECT_THAT(DroppedText(session, 10), HasSubstr("(the daemon was lost)"));
  session.awaits_acknowledgement = true;
  EXPECT_THAT(DroppedText(session, 10),
              HasSubstr("(the daemon has not acknowledged the sent messages)"));
}

}  // namespace
}  // namespace sweepstake::cli
