// The JSON document and the tables of a bench.
#include "engine_client/cli/bench/bench_output.h"

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
    row.aabb_checks_mean = 56'789;
    row.bytes = 400'000;
  }
  return row;
}

BenchReport SmallReport() {
  BenchReport report;
  report.machine.cpu = "Some CPU";
  report.machine.libraries = {{"Highway", "1.0.3"}};
  report.options.command_line = "sweepstake bench";
  report.options.frames = 40;
  report.options.thread_counts = {1, 2};
  report.cells = {{"suite-b", 1000, false}};
  report.rows = {Row(ContestantKind::kArm, "SAP", 0.5), Row(ContestantKind::kPeer, "Ode", 2)};
  report.rows[1].note = "stopped by the cap of 5.0 s";
  BenchRatio ratio;
  ratio.kind = RatioKind::kOverall;
  ratio.ours = "SAP";
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
  EXPECT_EQ(document["command_line"], "sweepstake bench");
  EXPECT_EQ(document["frames"], 40);
  EXPECT_EQ(document["threads"], (json{1, 2}));
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
  EXPECT_EQ(document["rows"][1]["kind"], "peer");
  EXPECT_TRUE(document["rows"][1]["bytes"].is_null());
  EXPECT_THAT(document["rows"][1]["note"].get<std::string>(), HasSubstr("cap"));
  EXPECT_EQ(document["ratios"][0]["kind"], "overall");
  EXPECT_EQ(document["ratios"][0]["objects"], 1000);
}

TEST(BenchTables, NameCellsNotesAndDifferences) {
  BenchReport report = SmallReport();
  std::ostringstream right;
  PrintBenchTables(report, right);
  EXPECT_THAT(right.str(), HasSubstr("suite-b, 1000 objects, 9.0 pairs per frame"));
  EXPECT_THAT(right.str(), HasSubstr("Ode in suite-b (1000 objects): stopped by the cap"));
  EXPECT_THAT(right.str(), Not(HasSubstr("FAILED")));
  report.rows[0].difference = "step 1: other pairs";
  std::ostringstream wrong;
  PrintBenchTables(report, wrong);
  EXPECT_THAT(wrong.str(), HasSubstr("FAILED SAP in suite-b (1000 objects): step 1"));
}

}  // namespace
}  // namespace sweepstake::cli
