// Tests the outputs of an experiment with known runs: CSV files, Tables 3 and 4, JSON document.
#include "tests/laboratory/experiment/experiment_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::MakeRecord;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// Returns a report with two cells and two policies with two runs each. The paper has only the first
// cell.
ExperimentReport Report() {
  ExperimentOptions options;
  options.scenes = {"brownian"};
  options.object_counts = {1000, 1234};
  options.policies = {"random", "paper"};
  options.run_count = 2;
  options.window = "100s";
  auto plan = MakePlan(options);
  EXPECT_TRUE(plan.ok());
  ExperimentReport report;
  report.plan = std::move(*plan);
  for (const PlannedRun& run : report.plan.runs) {
    const uint32_t dominant = run.policy == "paper" ? 1 : 2;
    report.records.push_back(
        MakeRecord(run.cell, run.policy, run.run, dominant, 50 + 10 * run.run));
  }
  report.cells = SummarizeCells(report.plan, report.records);
  return report;
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

// Returns the rows of a CSV file without quotes, the header first.
std::vector<std::vector<std::string>> ReadCsv(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    EXPECT_TRUE(line.ends_with('\r')) << path;
    rows.push_back(Cells(line.substr(0, line.size() - 1)));
  }
  return rows;
}

class ExperimentCsv : public testing::Test {
 protected:
  std::vector<std::vector<std::string>> Rows(const std::string& name,
                                             const ExperimentReport& report = Report()) {
    EXPECT_TRUE(WriteExperimentCsv(report, folder_.path()).ok());
    return ReadCsv(folder_.path() / name);
  }

  const test_support::TemporaryDirectory folder_;
};

TEST_F(ExperimentCsv, HasTheSameColumnsInEveryRowAndAllRowsOfEveryRun) {
  const ExperimentReport report = Report();
  const std::map<std::string, size_t> rows_per_run = {
      {"switches.csv", 0},  // counted below
      {"activations.csv", 0}, {"decisions.csv", 3}, {"posteriors.csv", 9},
      {"final.csv", 3},       {"metrics.csv", 1},   {"time.csv", 1},
  };
  size_t switch_count = 0;
  for (const RunRecord& record : report.records) switch_count += record.switches.size();
  for (const auto& [name, per_run] : rows_per_run) {
    const auto rows = Rows(name, report);
    size_t expected = per_run * report.records.size();
    if (name == "switches.csv") expected = switch_count;
    if (name == "activations.csv") expected = switch_count + report.records.size();
    EXPECT_EQ(rows.size(), 1 + expected) << name;
    for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size()) << name;
    EXPECT_EQ(rows[0][0], "run") << name;
    EXPECT_EQ(rows[1][0], "brownian-1000-random-1") << name;
    EXPECT_EQ(rows.back()[0], "brownian-1234-paper-2") << name;
  }
}

TEST_F(ExperimentCsv, ColumnsAreThoseOfTheContract) {
  EXPECT_THAT(Rows("activations.csv")[0],
              ElementsAre("run", "arm", "from_s", "to_s", "reason", "observed"));
  EXPECT_THAT(Rows("switches.csv")[0], ElementsAre("run", "time_s", "frame", "from", "to", "reason",
                                                   "observed", "rebuild_ns", "settling_ns"));
  EXPECT_THAT(Rows("decisions.csv")[0],
              ElementsAre("run", "time_s", "active", "candidate", "outcome", "reason", "reward",
                          "leader", "leader_best_probability", "expected_loss_ratio", "verdict"));
  EXPECT_THAT(Rows("posteriors.csv")[0],
              ElementsAre("run", "time_s", "arm", "alpha", "beta", "best_probability"));
  EXPECT_TRUE(Rows("ranking.csv").empty()) << "there are no traces";
}

TEST_F(ExperimentCsv, MarksWhatWasInTheObservationWindow) {
  const auto rows = Rows("switches.csv");
  EXPECT_THAT(rows[1], ElementsAre("brownian-1000-random-1", "2.0", "20", "SAP", "KDTree",
                                   "exploration", "0", "1000", "10"));
  EXPECT_THAT(rows[3], ElementsAre("brownian-1000-random-1", "66.0", "70", "Grid", "SAP", "policy",
                                   "1", "1000", "10"));
}

TEST_F(ExperimentCsv, LeavesBlankWhatADecisionHasNot) {
  ExperimentReport report = Report();
  RecordedDecision& first = report.records[0].decisions[0];
  first.candidate = -1;
  first.reward = -1;
  first.best_probability.clear();
  first.verdict = 0;
  const auto decisions = Rows("decisions.csv", report);
  EXPECT_THAT(decisions[1], ElementsAre("brownian-1000-random-1", "5.0", "Grid", "", "kept", "", "",
                                        "", "", "", "unknown"));
  EXPECT_EQ(decisions[2][3], "Grid");
  const auto posteriors = Rows("posteriors.csv", report);
  EXPECT_EQ(posteriors[1][5], "");
  EXPECT_EQ(posteriors[3][3], "9.0");
  EXPECT_EQ(posteriors[4][5], "0.05");
}

TEST_F(ExperimentCsv, ARunWithoutDecisionsEndsAtThePrior) {
  ExperimentReport report = Report();
  report.records[0].decisions.clear();
  const auto rows = Rows("final.csv", report);
  EXPECT_EQ(rows[1][2], "1.0");
  EXPECT_EQ(rows[1][4], "0.5");
  EXPECT_EQ(rows[1][5], "2.0");
}

TEST_F(ExperimentCsv, TimeHoldsEveryShareOfTheRunsTime) {
  ExperimentReport report = Report();
  report.records[0].shadow_visit_count = 11;
  report.records[0].warm_switch_count = 12;
  report.records[0].dropped_frame_count = 13;
  const auto time = Rows("time.csv", report);
  std::map<std::string, std::string> row;
  for (size_t i = 0; i < time[0].size(); ++i) row[time[0][i]] = time[1][i];
  EXPECT_EQ(row["scene_seed"] + row["decision_seed"], "1101");
  EXPECT_EQ(row["start_utc"], "2026-01-31T12:00:00Z");
  EXPECT_EQ(row["scene_step_ns"], "30000000");
  EXPECT_EQ(row["longest_decision_ns"], "60000");
  EXPECT_EQ(row["shadow_visits"] + row["warm_switches"] + row["dropped_frames"], "111213");
  EXPECT_EQ(row["decisions"], "3");
  EXPECT_THAT(Rows("metrics.csv", report)[1],
              ElementsAre("brownian-1000-random-1", "8.0", "Grid", "100", "30.0", "50.0", "20.0",
                          "1000.0", "60.0", "4096", "1000"));
}

TEST_F(ExperimentCsv, QuotesALabelWithAComma) {
  ExperimentReport report;
  report.records = {MakeRecord({"a,b.aabbs", 7}, "paper", 1, 0, 60)};
  ASSERT_TRUE(WriteExperimentCsv(report, folder_.path()).ok());
  EXPECT_THAT(test_support::FileText(folder_.path() / "final.csv"),
              HasSubstr("\r\n\"a,b-7-paper-1\",SAP,9.0,1.0,0.9,10.0,0.6,1,"));
}

TEST_F(ExperimentCsv, TablesHaveARowPerPolicyAndCellWithThePapersValuesBeside) {
  const auto rows = Rows("tables.csv");
  ASSERT_EQ(rows.size(), 5U);
  const auto value = [&](size_t row, const std::string& column) {
    const auto found = std::find(rows[0].begin(), rows[0].end(), column);
    return rows[row].at(static_cast<size_t>(found - rows[0].begin()));
  };
  EXPECT_EQ(value(1, "policy"), "random");
  EXPECT_EQ(value(1, "dominance"), "Grid 2/2");
  EXPECT_EQ(value(1, "interpretation"), "Stable preference for Grid.");
  EXPECT_EQ(value(1, "paper_dominance"), "AxisSweep 5/5");
  EXPECT_EQ(value(3, "active_percent"), "65.0");
  EXPECT_EQ(value(3, "mu"), "0.9");
  EXPECT_EQ(value(3, "paper_switches"), "20.2");
  EXPECT_EQ(value(3, "paper_n_sd"), "27.5");
  EXPECT_EQ(value(1, "paper_switches"), "20.2");
  for (const char* column : {"paper_mu", "paper_mu_sd", "paper_n", "paper_n_sd"}) {
    EXPECT_EQ(value(1, column), "") << "another policy's " << column << " is another quantity";
  }
  EXPECT_EQ(value(4, "objects"), "1234");
  EXPECT_EQ(value(4, "paper_switches"), "");
}

TEST_F(ExperimentCsv, AFolderThatIsNotThereIsNamed) {
  const Status status = WriteExperimentCsv(Report(), folder_.path() / "missing");
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), HasSubstr("missing"));
}

std::string Text(const ExperimentReport& report) {
  std::ostringstream out;
  PrintExperiment(report, "results", out);
  return out.str();
}

TEST(ExperimentText, HasBothTablesForEachPolicyInThePlansOrder) {
  const std::string text = Text(Report());
  const size_t table4 = text.find("\nTable 4. ");
  ASSERT_NE(table4, std::string::npos);
  for (const size_t begin : {text.find("\nTable 3. "), table4}) {
    EXPECT_LT(text.find("\nPolicy random\n", begin), text.find("\nPolicy paper\n", begin));
  }
  EXPECT_LT(text.find("\nPolicy paper\n"), table4);
}

TEST(ExperimentText, ACellThatThePaperHasNotStandsAlone) {
  const std::string text = Text(Report());
  EXPECT_THAT(text, HasSubstr("\nBrownian  1,234    KDTree 2/2           Stable preference for "
                              "KDTree.  –\n"));
  EXPECT_THAT(text, HasSubstr("  paper          AxisSweep  5 / 5  20.2±0.8  45.5±6.3    "
                              "0.977±0.007 / 196.4±27.5\nBrownian  1,234"));
  EXPECT_THAT(text, HasSubstr("\n  paper          AxisSweep  5 / 5  20.2±0.8  45.5±6.3    –\n"))
      << "the other policy's posterior is another quantity";
  EXPECT_THAT(text, testing::EndsWith("0.900±0.000 / 10.0±0.0\n"));
}

// Returns a cell with these times in ms, in which SAP is the best single arm.
CellTruth WorthCell(const std::string& scene, double best_ms, double always_ms, double oracle_ms,
                    double decided_ms) {
  CellTruth truth;
  truth.cell = {scene, 10'000};
  truth.worth = Worth{"SAP", best_ms, always_ms, oracle_ms, decided_ms};
  return truth;
}

TEST(WorthText, SaysWhatChoosingIsWorthAndWhereItIsWorthNothing) {
  ExperimentTruths truths;
  EXPECT_EQ(WorthText(truths), "");
  truths.cells = {
      WorthCell("storms", 2, 3, 1.5, 1.75), WorthCell("clusters", 4, 4.001, 3.999, 4.02), {}};
  EXPECT_EQ(WorthText(truths),
            "The best sequence of algorithms saves 0.751 ms of detection per frame against always "
            "KDTree and 0.250 ms against the best single algorithm of each cell, on average over 2 "
            "cells. AI Decides saves 0.616 ms against always KDTree. Choosing is worth most in "
            "storms 10,000: 1.50 ms of 3.00 ms against always KDTree. Choosing is worth nothing "
            "(less than 0.5 % of detection, or less than 0.010 ms) in 1 of 2 cells: clusters "
            "10,000.");
  truths.cells.erase(truths.cells.begin());
  EXPECT_THAT(WorthText(truths), HasSubstr("on average over 1 cell. "));
  EXPECT_THAT(WorthText(truths), testing::Not(HasSubstr("worth most")));
  truths.cells = {WorthCell("storms", 2, 3, 1.5, 1.75)};
  EXPECT_THAT(WorthText(truths), testing::EndsWith("Choosing is worth something in every cell."));
}

TEST(ExperimentText, SaysFirstWhatIsMissing) {
  ExperimentReport report = Report();
  EXPECT_THAT(Text(report), StartsWith("\nTable 3"));
  report.records.resize(5);
  report.cells = SummarizeCells(report.plan, report.records);
  EXPECT_THAT(Text(report),
              StartsWith("PARTIAL: 5 of 8 runs are finished; continue with --resume results\n"));
}

json Document(const ExperimentReport& report) {
  std::ostringstream out;
  PrintExperimentJson(report, "results", out);
  return json::parse(out.str());
}

TEST(ExperimentDocument, HasARowForEachPolicyAndCellOfThePlan) {
  const ExperimentReport report = Report();
  const json document = Document(report);
  EXPECT_EQ(document["complete"], true);
  std::vector<std::string> rows;
  for (const json& row : document["rows"]) {
    rows.push_back(row["policy"].get<std::string>() + " " + row["cell"].get<std::string>());
  }
  EXPECT_THAT(rows, ElementsAre("random brownian-1000", "random brownian-1234",
                                "paper brownian-1000", "paper brownian-1234"));
  const json& row = document["rows"][2];
  EXPECT_EQ(row["dominant"], "KDTree");
  EXPECT_EQ(row["active_percent"], 65);
  EXPECT_EQ(row["mu"], 0.9);
  EXPECT_EQ(row["n"], 10);
  EXPECT_EQ(row["dominant_runs"], json::parse(R"([{"arm":"KDTree","runs":2}])"));
  EXPECT_FALSE(row.contains("truly_fastest")) << "there are no traces";
}

TEST(ExperimentDocument, HasTheRunsByCellThenPolicyThenNumber) {
  const json document = Document(Report());
  std::vector<std::string> runs;
  for (const json& run : document["runs"]) {
    runs.push_back(run["cell"].get<std::string>().substr(9) + run["policy"].get<std::string>() +
                   run["run"].dump());
  }
  EXPECT_THAT(runs, ElementsAre("1000random1", "1000random2", "1000paper1", "1000paper2",
                                "1234random1", "1234random2", "1234paper1", "1234paper2"));
  const json& run = document["runs"][2];
  EXPECT_EQ(run["arms"], json(test_support::kRecordArms));
  EXPECT_NEAR(run["active_shares"][1].get<double>(), 0.6, 1e-12);
  EXPECT_EQ(run["decisions"], 3);
  EXPECT_EQ(run["scene_seed"], 1);
  EXPECT_EQ(run["time"].size(), 10U);
}

TEST(ExperimentDocument, SaysWhatWasAskedFor) {
  ExperimentReport report = Report();
  report.sessions = {{"sweepstake-lab experiment", "a", "b"}, {"sweepstake --resume", "c", "d"}};
  const json document = Document(report);
  EXPECT_EQ(document["options"]["policies"], json({"random", "paper"}));
  EXPECT_EQ(document["options"]["run_count"], 2);
  EXPECT_EQ(document["options"]["window"], "100s");
  EXPECT_EQ(document["options"]["replay_seed_count"], 30);
  EXPECT_EQ(document["sittings"][1]["start_utc"], "c");
  EXPECT_EQ(document["arms"].size(), BroadPhaseNames().size());
  EXPECT_EQ(document["cells"][1]["objects"], 1234);
  EXPECT_EQ(document["own_policy"], "adaptive");
}

TEST(ExperimentDocument, RowsOfAnAblationKeepItsName) {
  ExperimentReport report = Report();
  report.plan.options.policies = {"adaptive-without-gate"};
  for (RunRecord& record : report.records) record.policy = "adaptive-without-gate";
  report.cells = SummarizeCells(report.plan, report.records);
  const json document = Document(report);
  ASSERT_EQ(document["rows"].size(), 2U);
  EXPECT_EQ(document["rows"][0]["own_policy"], "adaptive-without-gate");
}

TEST(PaperTables, HaveNineCellsWhoseDominantArmIsTheFirstOfTable3) {
  EXPECT_EQ(PaperCells().size(), 9U);
  for (const PaperCell& cell : PaperCells()) {
    const std::string first =
        std::string(cell.dominant) + " " + std::to_string(cell.dominant_run_count) + "/5";
    EXPECT_THAT(std::string(cell.dominance), StartsWith(first));
    EXPECT_EQ(FindPaperCell(cell.scene, cell.object_count), &cell);
  }
  EXPECT_EQ(FindPaperCell("brownian", 1001), nullptr);
  EXPECT_EQ(FindPaperCell("suite-b", 1000), nullptr);
}

}  // namespace
}  // namespace sweepstake::cli
