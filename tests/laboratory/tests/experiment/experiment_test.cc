// Tests experiments without live runs: the files of records and the outputs made from them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/experiment/experiment_run.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::FileText;
using test_support::MakeRecord;
using test_support::PlanOf;
using test_support::TemporaryDirectory;
using testing::HasSubstr;

const ExperimentCell kCell{"brownian", 1000};

TEST(RunRecordFile, ComesBackAsItWas) {
  const TemporaryDirectory folder;
  const RunRecord record = MakeRecord(kCell, "paper", 1, 1, 60);
  ASSERT_TRUE(WriteRecord(record, folder.path() / "a.json").ok());
  const auto read = ReadRecord(folder.path() / "a.json");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_TRUE(WriteRecord(*read, folder.path() / "b.json").ok());
  EXPECT_EQ(FileText(folder.path() / "a.json"), FileText(folder.path() / "b.json"));
  EXPECT_EQ(read->decisions[1].best_probability, record.decisions[1].best_probability);
  EXPECT_EQ(read->seed, record.seed);
  EXPECT_EQ(read->scene_seed, record.scene_seed);
}

TEST(PlayedRun, CountsOnlyWhatIsInTheObservationWindow) {
  const RunRecord record = MakeRecord(kCell, "paper", 1, 1, 60);
  const PlayedRun summary = Summarize(record);
  EXPECT_EQ(summary.dominant_name(), "KDTree");
  EXPECT_NEAR(summary.active_shares[1], 0.6, 1e-12);
  EXPECT_NEAR(summary.active_shares[2], 0.4, 1e-12);
  EXPECT_EQ(summary.active_shares[0], 0);
  EXPECT_EQ(summary.switch_count, 2U) << "the exploration's are left out";
  EXPECT_DOUBLE_EQ(summary.posterior_mean, 0.9);
  EXPECT_DOUBLE_EQ(summary.evidence, 10);
  EXPECT_EQ(summary.verdict, Verdict::kStable);
}

TEST(PlayedRun, APeriodFromBeforeTheWindowCountsFromItsBeginning) {
  RunRecord record = MakeRecord(kCell, "paper", 1, 2, 25);
  const PlayedRun summary = Summarize(record);
  // Grid was the last explored arm and stayed active for a quarter of the window. SAP follows.
  EXPECT_NEAR(summary.active_shares[2], 0.25, 1e-12);
  EXPECT_NEAR(summary.active_shares[0], 0.75, 1e-12);
  EXPECT_EQ(summary.switch_count, 1U);
}

TEST(CellSummary, TakesSwitchesOverAllRunsAndTheRestOverDominantOnes) {
  ExperimentOptions options;
  options.scenes = {"brownian"};
  options.object_counts = {1000};
  options.policies = {"paper"};
  options.run_count = 3;
  const std::vector<RunRecord> records{MakeRecord(kCell, "paper", 1, 1, 60),
                                       MakeRecord(kCell, "paper", 2, 2, 90),
                                       MakeRecord(kCell, "paper", 3, 1, 70)};
  const auto cells = SummarizeCells(PlanOf(options), records);
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells[0].DominanceText(), "KDTree 2/3; Grid 1/3");
  EXPECT_EQ(cells[0].switches.count, 3U);
  EXPECT_NEAR(cells[0].switches.mean, 5.0 / 3, 1e-12);
  EXPECT_EQ(cells[0].active_percent.count, 2U);
  EXPECT_NEAR(cells[0].active_percent.mean, 65, 1e-9);
  EXPECT_NEAR(cells[0].active_percent.deviation, 7.0710678, 1e-6);
  EXPECT_EQ(cells[0].Interpretation(), "Transitional between KDTree and Grid.");
}

TEST(CellSummary, InterpretsSharesAndVerdicts) {
  CellSummary cell;
  cell.dominance = {{"SAP", 5}};
  cell.active_percent.mean = 80;
  cell.verdict = Verdict::kStable;
  EXPECT_EQ(cell.Interpretation(), "Strong stable preference for SAP.");
  cell.active_percent.mean = 45;
  EXPECT_EQ(cell.Interpretation(), "Stable preference for SAP.");
  cell.verdict = Verdict::kTie;
  EXPECT_EQ(cell.Interpretation(), "Preference for SAP; other arms are practically equal.");
  cell.verdict = Verdict::kDegraded;
  EXPECT_THAT(cell.Interpretation(), HasSubstr("misses the frame-rate floor"));
}

TEST(ExperimentTables, StandInThePapersLayoutWithItsFiguresBeside) {
  ExperimentOptions options;
  options.scenes = {"rotating-gravity"};
  options.object_counts = {1000};
  options.policies = {"paper"};
  options.run_count = 2;
  const ExperimentCell cell{"rotating-gravity", 1000};
  const std::vector<RunRecord> records{MakeRecord(cell, "paper", 1, 0, 60),
                                       MakeRecord(cell, "paper", 2, 0, 70)};
  ExperimentReport report;
  report.cells = SummarizeCells(PlanOf(options), records);
  report.records = records;
  report.plan.runs.resize(records.size());
  std::ostringstream out;
  PrintExperiment(report, "out", out);
  EXPECT_EQ(
      out.str(),
      "\nTable 3. Dominant algorithms across the runs.\n\n"
      "Scenario       Objects  Dominance frequency  Interpretation              Paper\n"
      "\nPolicy paper\n"
      "Rotating Grav  1,000    SAP 2/2              Stable preference for SAP.  SAP 3/5; "
      "AxisSweep 2/5\n"
      "\nTable 4. Switches over all runs; active time, posterior mean μ* and n* = α + β of the "
      "dominant arm over its runs; mean ± sample standard deviation. The paper's μ* and n* stand "
      "only "
      "below those of its own policy, because other policies measure other quantities.\n\n"
      "Scenario       Obj.   Dominant  Freq.  Switches  Active (%)  μ* / n*\n"
      "\nPolicy paper\n"
      "Rotating Grav  1,000  SAP       2 / 2  2.0±0.0   65.0±7.1    0.900±0.000 / 10.0±0.0\n"
      "  paper               SAP       3 / 5  20.0±1.2  42.3±2.9    0.905±0.006 / "
      "179.0±13.0\n");
}

TEST(ExperimentTables, OfOneRunHaveNoDeviation) {
  EXPECT_EQ(SpreadText({12.25, 0, 1}, 1), "12.2");
  EXPECT_EQ(SpreadText({12.25, 0, 2}, 1), "12.2±0.0");
}

TEST(MetricWindowMeter, ClosesAWindowPerIntervalAndPerArm) {
  MetricWindowMeter meter(100);
  FrameSample sample{};
  sample.detection_time_ns = 2000;
  for (uint64_t now_ns = 10; now_ns <= 150; now_ns += 10) {
    sample.frame_time_ns = now_ns * 1000;
    sample.arm = now_ns > 120 ? 1 : 0;
    meter.Add(sample, now_ns);
  }
  const auto windows = meter.Take(150);
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(windows[0].frame_count, 9U);
  EXPECT_DOUBLE_EQ(windows[0].frame_us_mean, 50);
  EXPECT_DOUBLE_EQ(windows[0].frame_us_max, 90);
  EXPECT_DOUBLE_EQ(windows[0].detection_us_mean, 2);
  EXPECT_EQ(windows[1].frame_count, 3U);
  EXPECT_EQ(windows[2].arm, 1U);
  EXPECT_EQ(windows[2].frame_count, 3U);
  EXPECT_TRUE(meter.Take(150).empty());
}

}  // namespace
}  // namespace sweepstake::cli
