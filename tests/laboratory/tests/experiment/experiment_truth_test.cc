// Tests the figures of experiment_truth.h and the JSON document, with a report in which every field
// is set.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::MakeRecord;
using testing::HasSubstr;
using testing::Not;

constexpr uint32_t kFrames = 400;

// Returns the trace of a scene in which KDTree takes 20 µs and Grid 60 µs, varied a little from
// frame to frame.
CostTrace Trace(uint64_t seed, uint64_t sap_ns) {
  CostTrace trace;
  trace.seed = seed;
  trace.scene = "brownian";
  trace.arms = {{"SAP", 1}, {"KDTree", 1}, {"Grid", 1}};
  trace.frame_count = kFrames;
  trace.control_arm = 1;
  trace.burst_frame_count = 8;
  const uint64_t costs_ns[] = {sap_ns, 20'000, 60'000};
  for (uint32_t frame = 0; frame < kFrames; ++frame) {
    trace.object_count.push_back(1000);
    trace.pair_count.push_back(10);
    trace.step_ns.push_back(5000);
    trace.control_ns.push_back(20'200);
    for (const uint64_t cost_ns : costs_ns) {
      trace.detection_ns.push_back(cost_ns + frame % 7 * 10);
      trace.aabb_check_count.push_back(1000);
      trace.native_bytes.push_back(4096);
    }
  }
  TraceBurst burst;
  for (const uint64_t cost_ns : costs_ns) {
    for (int k = 0; k < 8; ++k) burst.detection_ns.push_back(k == 0 ? 3 * cost_ns : cost_ns);
  }
  trace.bursts = {burst};
  return trace;
}

// Returns the traces of two scenes, in which SAP takes 30 µs and 40 µs. The runs 1 and 2 have their
// seeds.
std::vector<CostTrace> Traces() { return {Trace(1, 30'000), Trace(2, 40'000)}; }

ExperimentPlan TruthPlan() {
  ExperimentOptions options;
  options.scenes = {"brownian"};
  options.object_counts = {1000, 3000};
  options.policies = {"paper", "adaptive"};
  options.run_count = 2;
  options.window = "100s";
  options.replay_seed_count = 4;
  auto plan = MakePlan(options);
  EXPECT_TRUE(plan.ok());
  return std::move(*plan);
}

// Returns a report in which the larger cell has one run and no trace.
ExperimentReport TruthReport() {
  ExperimentReport report;
  report.plan = TruthPlan();
  report.sessions = {{"sweepstake-lab experiment '<x>'", "2026-01-31T12:00:00Z", ""}};
  report.machine.cpu = "Some <CPU> & Co";
  const auto& cells = report.plan.cells;
  report.records = {
      MakeRecord(cells[0], "paper", 1, 1, 60), MakeRecord(cells[0], "paper", 2, 0, 60),
      MakeRecord(cells[0], "adaptive", 1, 1, 95), MakeRecord(cells[0], "adaptive", 2, 1, 90),
      MakeRecord(cells[1], "paper", 1, 2, 70)};
  report.records[0].switches.back().reason = 3;
  report.cells = SummarizeCells(report.plan, report.records);
  return report;
}

ExperimentReport Assess() {
  ExperimentReport report = TruthReport();
  std::vector<const CellSummary*> cells;
  for (const CellSummary& cell : report.cells) {
    if (cell.cell == report.plan.cells[0]) cells.push_back(&cell);
  }
  CellTruth truth = RankArms(report.plan.cells[0], Traces());
  const Status status = AssessCell(
      Traces(), cells, {.seed_count = 4}, [](double) {}, truth);
  EXPECT_TRUE(status.ok()) << status.message();
  report.truths.cells.push_back(std::move(truth));
  report.truths.over_cells = CompareOverCells(report.truths.cells);
  return report;
}

// Assesses the report once, because the games take a second.
const ExperimentReport& AssessedReport() {
  static const ExperimentReport report = Assess();
  return report;
}

nlohmann::json TruthDocument(const ExperimentReport& report) {
  std::ostringstream out;
  PrintExperimentJson(report, "out", out);
  return nlohmann::json::parse(out.str());
}

TEST(ExperimentJson, HoldsEveryRowAndRun) {
  const ExperimentReport& report = AssessedReport();
  const nlohmann::json document = TruthDocument(report);
  EXPECT_EQ(document["command"], "experiment");
  EXPECT_EQ(document["folder"], "out");
  EXPECT_EQ(document["complete"], false);
  EXPECT_EQ(document["finished_runs"], 5);
  EXPECT_EQ(document["planned_runs"], 8);
  ASSERT_EQ(document["rows"].size(), 3U);
  const nlohmann::json& row = document["rows"][0];
  EXPECT_EQ(row["dominance"], "KDTree 1/2; SAP 1/2");
  EXPECT_EQ(row["truly_fastest"], "KDTree");
  EXPECT_EQ(row["dominant_runs"][1]["runs"], 1);
  EXPECT_EQ(document["runs"].size(), report.records.size());
  EXPECT_EQ(document["machine"]["cpu"], "Some <CPU> & Co");
}

TEST(ExperimentJson, HoldsWhatTheChartsOfARunAreDrawnFrom) {
  const nlohmann::json document = TruthDocument(AssessedReport());
  const nlohmann::json& run = document["runs"][0];
  EXPECT_EQ(run["dominant"], "KDTree");
  ASSERT_EQ(run["periods"].size(), 5U);
  EXPECT_EQ(run["periods"][0]["reason"], "");
  EXPECT_EQ(run["periods"][1]["arm"], 1);
  EXPECT_EQ(run["periods"].back()["to_s"], run["end_s"]);
  ASSERT_EQ(run["bail_outs"].size(), 1U);
  EXPECT_EQ(run["bail_outs"][0]["arm"], 1);
  EXPECT_EQ(run["held_back_s"], (nlohmann::json{5.0, 105.0}))
      << "another arm was the candidate twice";
  ASSERT_EQ(run["posteriors"].size(), 3U);
  EXPECT_NEAR(run["posteriors"][2]["means"][1].get<double>(), 0.9, 1e-12);
  EXPECT_EQ(run["verdicts"]["stable"], 2) << "the exploration's decision is left out";
  EXPECT_EQ(run["time"]["rebuild_ns"], 500'000);
}

TEST(ExperimentJson, ThinsLongPosteriorsAndKeepsTheirEnd) {
  ExperimentReport report = TruthReport();
  RunRecord& record = report.records[0];
  const RecordedDecision last = record.decisions.back();
  for (int i = 1; i <= 997; ++i) {
    record.decisions.push_back(last);
    record.decisions.back().time_s += i;
  }
  report.cells = SummarizeCells(report.plan, report.records);
  const nlohmann::json points = TruthDocument(report)["runs"][0]["posteriors"];
  EXPECT_LE(points.size(), 51U);
  EXPECT_EQ(points.back()["time_s"], last.time_s + 997);
}

TEST(ExperimentJson, HoldsTheTruthWhereThereIsOne) {
  const nlohmann::json document = TruthDocument(AssessedReport());
  ASSERT_EQ(document["truths"].size(), 1U);
  const nlohmann::json& truth = document["truths"][0];
  EXPECT_EQ(truth["cell"], "brownian-1000");
  EXPECT_EQ(truth["scenes"], 2);
  EXPECT_EQ(truth["ranking"][0]["arm"], "KDTree");
  EXPECT_EQ(truth["agreements"].size(), 2U);
  EXPECT_EQ(truth["comparisons"].size(), document["over_cells"].size());
  EXPECT_TRUE(TruthDocument(TruthReport())["truths"].empty());
}

TEST(CellTruth, RanksTheArmsAndComparesATwin) {
  std::vector<CostTrace> traces = Traces();
  for (uint64_t& control_ns : traces[1].control_ns) control_ns = 19'000;
  const CellTruth truth = RankArms({"brownian", 1000}, traces);
  EXPECT_EQ(truth.scene_count, 2U);
  ASSERT_EQ(truth.ranking.size(), 3U);
  EXPECT_EQ(truth.ranking[0].arm, "KDTree");
  EXPECT_EQ(truth.ranking[0].ratio, 1);
  EXPECT_EQ(truth.ranking[1].arm, "SAP");
  EXPECT_NEAR(truth.ranking[1].mean_ns, 35'030, 1) << "the mean over the scenes";
  EXPECT_NEAR(truth.ranking[2].ratio, 3, 0.01);
  EXPECT_NEAR(truth.control_ratio, 0.9486, 0.001) << "the scene with the larger difference";
}

TEST(CellTruth, ReplaysPoliciesArmsAndOracleAndComparesThem) {
  const ExperimentReport& report = AssessedReport();
  const CellTruth& truth = report.truths.cells[0];
  const auto player = [&](const std::string& name) -> const ReplayedPlayer& {
    return *std::find_if(truth.players.begin(), truth.players.end(),
                         [&](const ReplayedPlayer& each) { return each.name == name; });
  };
  EXPECT_NEAR(player("fixed:KDTree").row.regret_best_fixed, 0, 1e-9);
  EXPECT_NEAR(player("fixed:SAP").row.regret_best_fixed, 0.75, 0.01);
  ASSERT_EQ(player("fixed:SAP").scene_regrets.size(), 2U);
  EXPECT_NEAR(player("fixed:SAP").scene_regrets[0], 0.5, 0.01);
  EXPECT_NEAR(player("fixed:SAP").scene_regrets[1], 1, 0.01);
  EXPECT_EQ(player("paper").row.ci95.low, BootstrapMean(player("paper").scene_regrets).low)
      << "the interval is over the scenes";
  EXPECT_GT(player("paper").row.regret_best_fixed, 0);
  EXPECT_EQ(player("paper").row.games.size(), 4U);
  EXPECT_LT(player("adaptive").row.regret_best_fixed, player("paper").row.regret_best_fixed);
  EXPECT_FALSE(player("oracle").is_policy);
  for (const ReplayedPlayer& each : truth.players) {
    EXPECT_THAT(each.name, Not(HasSubstr("-without-"))) << "ablations are no baselines";
  }
  for (const PairedComparison& each : truth.comparisons) {
    EXPECT_EQ(each.policy, OwnPolicyName("default"));
    EXPECT_NE(each.baseline, each.policy);
    EXPECT_GE(each.corrected_probability, each.wilcoxon.probability);
    EXPECT_LE(each.wilcoxon.pair_count, 2U) << "a pair per scene, not per game";
  }
  EXPECT_EQ(report.truths.over_cells.size(), truth.comparisons.size());
  EXPECT_EQ(truth.comparisons.back().baseline, "fixed:KDTree");
}

TEST(CellTruth, SaysWhatChoosingIsWorth) {
  const CellTruth& truth = AssessedReport().truths.cells[0];
  ASSERT_TRUE(truth.worth);
  EXPECT_EQ(truth.worth->best_arm, "KDTree");
  EXPECT_NEAR(truth.worth->best_ms, 0.02, 1e-4);
  EXPECT_EQ(truth.worth->always_ms, truth.worth->best_ms);
  EXPECT_NEAR(truth.worth->oracle_ms, 0.02, 1e-4);
  EXPECT_GT(truth.worth->decided_ms, 0.02);
  EXPECT_TRUE(truth.worth->is_nothing()) << "one arm is always the fastest";
  EXPECT_FALSE((Worth{"SAP", 2, 3, 1.999, 2}).is_nothing()) << "KDTree is slower";
  EXPECT_TRUE((Worth{"SAP", 0.009, 0.01, 0.001, 0.009}).is_nothing()) << "all arms are fast";
  EXPECT_FALSE((Worth{"SAP", 0.03, 0.03, 0.01, 0.03}).is_nothing());
}

TEST(Agreement, ComparesTheLiveRunsWithReplaysInterval) {
  const ExperimentReport& report = AssessedReport();
  ASSERT_EQ(report.truths.cells[0].agreements.size(), 2U);
  const Agreement& paper = report.truths.cells[0].agreements[0];
  EXPECT_EQ(paper.policy, "paper");
  EXPECT_EQ(paper.runs.size(), 2U);
  EXPECT_NEAR(paper.active_share, 0.6, 1e-9);
  // Each of the three arms ran as many frames as the others, at 20, 30 (in the second scene 40) and
  // 60 µs plus 35 µs of other work.
  EXPECT_NEAR(paper.runs[0].by_trace, (110.0 / 3 + 35) / 55 - 1, 0.01);
  EXPECT_NEAR(paper.runs[1].by_trace, (120.0 / 3 + 35) / 55 - 1, 0.01);
  EXPECT_NEAR(paper.regret, (115.0 / 3 + 35) / 55 - 1, 0.01);
  EXPECT_NEAR(paper.measured_regret, 40.0 / 60 - 1, 1e-9);
  Agreement agreement;
  agreement.regret = 0.1;
  agreement.replayed_regret = {0.05, 0.2};
  EXPECT_TRUE(agreement.regret_agrees());
  agreement.regret = 0.21;
  EXPECT_FALSE(agreement.regret_agrees());
}

TEST(TruthCsv, HasRowsOfEveryPart) {
  const test_support::TemporaryDirectory folder;
  ASSERT_TRUE(WriteExperimentCsv(AssessedReport(), folder.path()).ok());
  for (const auto& [name, header] :
       {std::pair{"ranking.csv", "cell,arm,mean_ns,ratio\r\n"},
        {"worth.csv", "cell,best_arm,best_ms,always_ms,oracle_ms,decided_ms,nothing\r\n"},
        {"regret.csv", "cell,player,scene,seed,regret\r\n"},
        {"agreement.csv", "cell,policy,runs,regret,replayed_regret_low,replayed_regret_high,"},
        {"live_regret.csv", "cell,policy,run,measured_regret,regret_by_trace,active_share\r\n"},
        {"comparisons.csv", "cell,policy,baseline,pairs,difference,ci95_low,ci95_high,p,"}}) {
    const std::string text = test_support::FileText(folder.path() / name);
    EXPECT_THAT(text, testing::StartsWith(header)) << name;
    EXPECT_THAT(text, HasSubstr("\r\nbrownian-1000,")) << name;
  }
}

}  // namespace
}  // namespace sweepstake::cli
