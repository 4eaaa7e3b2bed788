// Experiments without their live runs: the files of records and the outputs made from them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/laboratory/experiment/experiment_live.h"
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
using testing::ElementsAre;
using testing::HasSubstr;

const ExperimentCell kCell{"brownian", 1000, 1};

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
  // Grid was explored last and stayed for a quarter; the next arm is SAP.
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
  const ExperimentCell cell{"rotating-gravity", 1000, 1};
  const std::vector<RunRecord> records{MakeRecord(cell, "paper", 1, 0, 60),
                                       MakeRecord(cell, "paper", 2, 0, 70)};
  ExperimentReport report;
  report.cells = SummarizeCells(PlanOf(options), records);
  report.records = records;
  report.plan.runs.resize(records.size());
  std::ostringstream out;
  PrintExperiment(report, "out", out);
  EXPECT_EQ(out.str(),
            "\nTable 3 with policy paper. Dominant algorithms across the runs.\n\n"
            "Scenario       Objects  Dominance frequency  Interpretation              Paper\n"
            "Rotating Grav  1,000    SAP 2/2              Stable preference for SAP.  SAP 3/5; "
            "AxisSweep 2/5\n"
            "\nTable 4 with policy paper. Switches over all runs; active time, μ* and n* over the "
            "dominant runs; mean ± sample standard deviation.\n\n"
            "Scenario       Obj.   Dominant  Freq.  Switches  Active (%)  μ* / n*\n"
            "Rotating Grav  1,000  SAP       2 / 2  2.0±0.0   65.0±7.1    0.900±0.000 / 10.0±0.0\n"
            "  paper               SAP       3 / 5  20.0±1.2  42.3±2.9    0.905±0.006 / "
            "179.0±13.0\n");
}

TEST(ExperimentTables, OfOneRunHaveNoDeviation) {
  EXPECT_EQ(SpreadText({12.25, 0, 1}, 1), "12.2");
  EXPECT_EQ(SpreadText({12.25, 0, 2}, 1), "12.2±0.0");
}

TEST(ExperimentFolder, FindsTheRunsThatAreThereAndFit) {
  const TemporaryDirectory root;
  const ExperimentFolder folder(root.path() / "out");
  ASSERT_TRUE(folder.Create().ok());
  ExperimentOptions options;
  options.scenes = {"brownian"};
  options.object_counts = {1000};
  options.run_count = 2;
  const ExperimentPlan plan = PlanOf(options);
  EXPECT_TRUE(folder.ReadRecords(plan).empty());
  RunRecord record = MakeRecord(plan.cells[0], "default", 2, 1, 60);
  record.seed = plan.runs[3].seed;
  ASSERT_TRUE(WriteRecord(record, folder.RunFile(plan.runs[3])).ok());
  // A record with another seed, and a file that is not a record.
  ASSERT_TRUE(
      WriteRecord(MakeRecord(plan.cells[0], "paper", 1, 1, 60), folder.RunFile(plan.runs[0])).ok());
  std::ofstream(folder.RunFile(plan.runs[1])) << "{";
  const auto records = folder.ReadRecords(plan);
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(RunLabel(records[0]), "brownian-1000-default-2");
}

TEST(ExperimentFolder, ItsManifestBringsTheOptionsBack) {
  const TemporaryDirectory root;
  const ExperimentFolder folder(root.path() / "out");
  EXPECT_THAT(folder.ReadManifest().status().message(), HasSubstr("there is no experiment in"));
  ASSERT_TRUE(folder.Create().ok());
  ExperimentOptions options;
  options.quick = true;
  options.seed = ~uint64_t{0};
  options.time_scale = 60;
  const ExperimentPlan plan = PlanOf(options);
  ASSERT_TRUE(
      folder.WriteManifest(ManifestJson(plan, {{"sweepstake-lab experiment", "start", ""}}, 2))
          .ok());
  const auto manifest = folder.ReadManifest();
  ASSERT_TRUE(manifest.ok());
  EXPECT_EQ(manifest->options.seed, options.seed);
  EXPECT_THAT(manifest->options.object_counts, ElementsAre(1000, 3000));
  EXPECT_EQ(manifest->sessions[0].command_line, "sweepstake-lab experiment");
  EXPECT_THAT(FileText(folder.path() / "manifest.json"), HasSubstr("\"state\": \"partial\""));
  EXPECT_THAT(folder.Create().message(), HasSubstr("--resume"));
}

TEST(RawCsv, HasEveryRunAndQuotesWhatNeedsIt) {
  const TemporaryDirectory folder;
  const ExperimentCell odd{"a,b.aabbs", 7, 1};
  ExperimentReport report;
  report.records = {MakeRecord(kCell, "paper", 1, 1, 60), MakeRecord(odd, "paper", 1, 0, 60)};
  ASSERT_TRUE(WriteExperimentCsv(report, folder.path()).ok());
  const std::string final_rows = FileText(folder.path() / "final.csv");
  EXPECT_THAT(final_rows, HasSubstr("\r\nbrownian-1000-paper-1,KDTree,9.000000000,1.000000000,"
                                    "0.900000000,10.000000000,0.600000000,1,"));
  EXPECT_THAT(final_rows, HasSubstr("\r\n\"a,b-7-paper-1\",SAP,"));
  EXPECT_THAT(FileText(folder.path() / "switches.csv"),
              HasSubstr("\r\nbrownian-1000-paper-1,66.000000,70,KDTree,Grid,policy,1,1000,10"));
  EXPECT_THAT(FileText(folder.path() / "activations.csv"),
              HasSubstr("\r\nbrownian-1000-paper-1,KDTree,6.000000,66.000000,policy,1"));
  EXPECT_THAT(
      FileText(folder.path() / "decisions.csv"),
      HasSubstr(
          "\r\nbrownian-1000-paper-1,105.000000,Grid,KDTree,held-cooldown,,0.900000000,KDTree,"
          "0.900000000,0.001000000,stable"));
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

TEST(DurationText, IsAsExactAsOneWantsToKnow) {
  EXPECT_EQ(DurationText(40'400'000'000), "40 s");
  EXPECT_EQ(DurationText(600'000'000'000), "10 min");
  EXPECT_EQ(DurationText(7'300'000'000'000), "2 h 2 min");
}

}  // namespace
}  // namespace sweepstake::cli
