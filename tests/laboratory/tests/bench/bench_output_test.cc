// Tests the JSON document and the tables of a bench.
#include "tests/laboratory/bench/bench_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

BenchRow Row(ContestantKind kind, const std::string& name, double ms_median) {
  BenchRow row;
  row.kind = kind;
  row.family = "SAP";
  row.name = name;
  row.frame_count = 40;
  row.ms_median = ms_median;
  row.pairs_mean = 9;
  if (kind == ContestantKind::kArm) {
    row.simd = "avx2";
    row.aabb_checks_mean = 56'789;
    row.bytes = 400'000;
  }
  return row;
}

BenchReport SmallReport() {
  BenchReport report;
  report.machine.cpu = "Some CPU";
  report.machine.libraries = {{"Highway", "1.0.3"}};
  report.options.command_line = "sweepstake-lab bench";
  report.options.frames = 40;
  report.options.thread_counts = {1, 2};
  report.options.simd = {"avx2"};
  report.cells = {{"suite-b", 1000}};
  report.rows = {Row(ContestantKind::kArm, "SAP", 0.5), Row(ContestantKind::kPeer, "Ode", 2)};
  report.rows[1].note = "stopped by the cap of 5.0 s";
  BenchRatio ratio;
  ratio.kind = RatioKind::kOverall;
  ratio.ours = "SAP";
  ratio.simd = "avx2";
  ratio.other = "Ode";
  ratio.value = 4;
  report.ratios = {ratio};
  return report;
}

json Document(const BenchReport& report) {
  std::ostringstream out;
  PrintBenchJson(report, out);
  return json::parse(out.str());
}

TEST(BenchJson, HoldsWhatWasAskedForAndWhere) {
  const json document = Document(SmallReport());
  EXPECT_EQ(document["command"], "bench");
  EXPECT_EQ(document["command_line"], "sweepstake-lab bench");
  EXPECT_EQ(document["frames"], 40);
  EXPECT_EQ(document["threads"], (json{1, 2}));
  EXPECT_EQ(document["simd"], json{"avx2"});
  EXPECT_EQ(document["peers"], false);
  EXPECT_EQ(document["machine"]["cpu"], "Some CPU");
  EXPECT_EQ(document["machine"]["libraries"]["Highway"], "1.0.3");
}

TEST(BenchJson, HoldsEveryRowAndRatioWithItsCell) {
  const json document = Document(SmallReport());
  ASSERT_EQ(document["rows"].size(), 2U);
  EXPECT_EQ(document["rows"][0]["scene"], "suite-b");
  EXPECT_EQ(document["rows"][0]["bytes"], 400'000);
  EXPECT_FALSE(document["rows"][0].contains("note"));
  EXPECT_EQ(document["rows"][0]["simd"], "avx2");
  EXPECT_EQ(document["rows"][1]["kind"], "peer");
  EXPECT_TRUE(document["rows"][1]["simd"].is_null());
  EXPECT_TRUE(document["rows"][1]["bytes"].is_null());
  EXPECT_THAT(document["rows"][1]["note"].get<std::string>(), HasSubstr("cap"));
  EXPECT_EQ(document["ratios"][0]["kind"], "overall");
  EXPECT_EQ(document["ratios"][0]["objects"], 1000);
  EXPECT_EQ(document["ratios"][0]["simd"], "avx2");
}

TEST(BenchTable, NameCellsNotesAndDifferences) {
  BenchReport report = SmallReport();
  std::ostringstream right;
  PrintBenchTable(report, right);
  EXPECT_THAT(right.str(), HasSubstr("suite-b, 1000 objects, 9.0 pairs per frame"));
  EXPECT_THAT(right.str(), HasSubstr("Ode in suite-b (1000 objects): stopped by the cap"));
  EXPECT_THAT(right.str(), Not(HasSubstr("FAILED")));
  report.rows[0].difference = "step 1: other pairs";
  std::ostringstream wrong;
  PrintBenchTable(report, wrong);
  EXPECT_THAT(wrong.str(), HasSubstr("FAILED SAP in suite-b (1000 objects): step 1"));
}

TEST(BenchJson, SaysNullWhereNothingWasMeasured) {
  BenchReport report = SmallReport();
  report.ratios[0].value_mean = 3.5;
  report.speedups = {
      {.cell = 0, .arm = "SAP", .simd = "avx2", .peer = "Ode", .median = 4, .mean = 3.5}};
  const json document = Document(report);
  EXPECT_TRUE(document["rows"][1]["aabb_checks_mean"].is_null());
  EXPECT_TRUE(document["rows"][0]["bytes_with_pairs"].is_null());
  EXPECT_EQ(document["ratios"][0]["value_mean"], 3.5);
  EXPECT_TRUE(Document(SmallReport())["ratios"][0]["value_mean"].is_null());
  ASSERT_EQ(document["speedups"].size(), 1U);
  EXPECT_EQ(document["speedups"][0]["scene"], "suite-b");
  EXPECT_EQ(document["speedups"][0]["peer"], "Ode");
  EXPECT_EQ(document["speedups"][0]["simd"], "avx2");
}

TEST(BenchTable, HaveTheFamilyAndTheFramesWithPeersOnly) {
  BenchReport report = SmallReport();
  std::ostringstream alone;
  PrintBenchTable(report, alone);
  EXPECT_THAT(alone.str(), testing::StartsWith("arm "));
  EXPECT_THAT(alone.str(), HasSubstr("Some CPU, 0 cores"));
  EXPECT_THAT(alone.str(), Not(HasSubstr("cold caches")));
  report.options.peers = true;
  report.options.cold = true;
  report.machine.absent_peers = {"Bullet, libbullet-dev"};
  std::ostringstream beside;
  PrintBenchTable(report, beside);
  EXPECT_THAT(beside.str(), testing::ContainsRegex("^family +arm +thr +frames +ms_median"));
  EXPECT_THAT(beside.str(), HasSubstr("cold caches"));
  EXPECT_THAT(beside.str(), HasSubstr("\nHighway 1.0.3\nLeft out: Bullet, libbullet-dev\n"));
}

TEST(BenchTable, HaveTheInstructionSetWhereSeveralWereMeasured) {
  BenchReport report = SmallReport();
  std::ostringstream one;
  PrintBenchTable(report, one);
  EXPECT_THAT(one.str(), Not(HasSubstr("simd")));
  report.options.simd = {"avx2", "sse4"};
  report.rows.insert(report.rows.begin() + 1, Row(ContestantKind::kArm, "SAP", 0.75));
  report.rows[1].simd = "sse4";
  report.rows[1].difference = "step 1: other pairs";
  std::ostringstream several;
  PrintBenchTable(report, several);
  EXPECT_THAT(several.str(), testing::ContainsRegex("^arm +simd +thr +ms_median"));
  EXPECT_THAT(several.str(), testing::ContainsRegex("\nSAP +sse4 +1 +0.7500"));
  EXPECT_THAT(several.str(), testing::ContainsRegex("\nOde +- +1 +2.0000"));
  EXPECT_THAT(several.str(), HasSubstr("FAILED SAP with sse4 in suite-b (1000 objects): step 1"));
  report.options.peers = true;
  std::ostringstream beside;
  PrintBenchTable(report, beside);
  EXPECT_THAT(beside.str(), testing::ContainsRegex("^family +arm +simd +thr +frames +ms_median"));
}

}  // namespace
}  // namespace sweepstake::cli
