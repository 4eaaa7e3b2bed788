// The outputs of an experiment with known runs: CSV files, tables 3 and 4, JSON document.
#include "tests/laboratory/experiment/experiment_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "tests/laboratory/experiment/paper_tables.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::MakeRecord;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// Two cells, of which the paper has only the first; two policies with two runs each.
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

// The rows of a CSV file without quotes, the header first.
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
  EXPECT_THAT(Rows("table3.csv")[0],
              ElementsAre("policy", "scene", "objects", "runs", "dominance", "interpretation",
                          "verdict", "paper_dominance", "paper_interpretation"));
  EXPECT_THAT(Rows("ranking.csv")[0],
              ElementsAre("cell", "arm", "detection_ns_mean", "ratio", "control_ratio"));
  EXPECT_EQ(Rows("ranking.csv").size(), 1U) << "there are no traces";
}

TEST_F(ExperimentCsv, MarksWhatWasInTheObservationWindow) {
  const auto rows = Rows("switches.csv");
  EXPECT_THAT(rows[1], ElementsAre("brownian-1000-random-1", "2.000000", "20", "SAP", "KDTree",
                                   "exploration", "0", "1000", "10"));
  EXPECT_THAT(rows[3], ElementsAre("brownian-1000-random-1", "66.000000", "70", "Grid", "SAP",
                                   "policy", "1", "1000", "10"));
}

TEST_F(ExperimentCsv, LeavesBlankWhatADecisionHasNot) {
  ExperimentReport report = Report();
  RecordedDecision& first = report.records[0].decisions[0];
  first.candidate = -1;
  first.reward = -1;
  first.best_probability.clear();
  first.verdict = 0;
  const auto decisions = Rows("decisions.csv", report);
  EXPECT_THAT(decisions[1], ElementsAre("brownian-1000-random-1", "5.000000", "Grid", "", "kept",
                                        "", "", "", "", "", "unknown"));
  EXPECT_EQ(decisions[2][3], "Grid");
  const auto posteriors = Rows("posteriors.csv", report);
  EXPECT_EQ(posteriors[1][5], "");
  EXPECT_EQ(posteriors[3][3], "9.000000000");
  EXPECT_EQ(posteriors[4][5], "0.050000000");
}

TEST_F(ExperimentCsv, ARunWithoutDecisionsEndsAtThePrior) {
  ExperimentReport report = Report();
  report.records[0].decisions.clear();
  const auto rows = Rows("final.csv", report);
  EXPECT_EQ(rows[1][2], "1.000000000");
  EXPECT_EQ(rows[1][4], "0.500000000");
  EXPECT_EQ(rows[1][5], "2.000000000");
}

TEST_F(ExperimentCsv, TimeHoldsEveryShareOfTheRunsTime) {
  ExperimentReport report = Report();
  report.records[0].shadow_visit_count = 11;
  report.records[0].warm_switch_count = 12;
  report.records[0].dropped_frame_count = 13;
  EXPECT_THAT(
      Rows("time.csv", report)[1],
      ElementsAre("brownian-1000-random-1", "2026-01-31T12:00:00Z", "6.000000", "106.000000",
                  "30000000", "80000000", "500000", "1500000", "500000", "100000", "1000000",
                  "300000", "60000", "9000000", "11", "12", "3", "13"));
  EXPECT_THAT(Rows("metrics.csv", report)[1],
              ElementsAre("brownian-1000-random-1", "8.000000", "Grid", "100", "30.000", "50.000",
                          "20.000", "1000.0", "60.0", "4096", "1000"));
}

TEST_F(ExperimentCsv, Table3HasARowPerPolicyAndCellWithThePapersWordsBeside) {
  const auto rows = Rows("table3.csv");
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_THAT(rows[1], ElementsAre("random", "brownian", "1000", "2", "Grid 2/2",
                                   "Stable preference for Grid.", "stable", "AxisSweep 5/5",
                                   "Stable sweep-based preference."));
  EXPECT_THAT(rows[4], ElementsAre("paper", "brownian", "1234", "2", "KDTree 2/2",
                                   "Stable preference for KDTree.", "stable", "", ""));
}

TEST_F(ExperimentCsv, Table4HasOurFiguresAndThePapers) {
  const auto rows = Rows("table4.csv");
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0].size(), 24U);
  EXPECT_THAT(rows[3], ElementsAre("paper", "brownian", "1000", "2", "KDTree", "2", "2.000000",
                                   "0.000000", "65.000000", "7.071068", "0.900000", "0.000000",
                                   "10.000000", "0.000000", "AxisSweep", "5", "20.200", "0.800",
                                   "45.500", "6.300", "0.977", "0.007", "196.400", "27.500"));
  EXPECT_EQ(rows[4][13], "0.000000");
  EXPECT_TRUE(std::all_of(rows[4].begin() + 14, rows[4].end(),
                          [](const std::string& cell) { return cell.empty(); }));
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
  const size_t first3 = text.find("Table 3 with policy random.");
  const size_t first4 = text.find("Table 4 with policy random.");
  const size_t second3 = text.find("Table 3 with policy paper.");
  const size_t second4 = text.find("Table 4 with policy paper.");
  EXPECT_LT(first3, first4);
  EXPECT_LT(first4, second3);
  EXPECT_LT(second3, second4);
  EXPECT_NE(second4, std::string::npos);
  EXPECT_THAT(text, Not(HasSubstr("True ranking"))) << "there are no traces";
}

TEST(ExperimentText, ACellThatThePaperHasNotStandsAlone) {
  const std::string text = Text(Report());
  EXPECT_THAT(text, HasSubstr("\nBrownian  1,234    KDTree 2/2           Stable preference for "
                              "KDTree.  –\n"));
  EXPECT_THAT(text, HasSubstr("  paper          AxisSweep  5 / 5  20.2±0.8  45.5±6.3    "
                              "0.977±0.007 / 196.4±27.5\nBrownian  1,234"));
  EXPECT_THAT(text, testing::EndsWith("0.900±0.000 / 10.0±0.0\n"));
}

TEST(ExperimentText, SaysFirstWhatIsMissing) {
  ExperimentReport report = Report();
  EXPECT_THAT(Text(report), StartsWith("\nTable 3"));
  report.records.resize(5);
  report.cells = SummarizeCells(report.plan, report.records);
  EXPECT_THAT(Text(report), StartsWith("PARTIAL: 5 of 8 runs; continue with --resume results\n"));
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
  EXPECT_EQ(run["time_ns"].size(), 9U);
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
