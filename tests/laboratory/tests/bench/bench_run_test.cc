// Runs a bench on scenes so small that it takes milliseconds, and checks that it has the requested
// rows. No time is compared.
#include "tests/laboratory/bench/bench_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "sweepstake/simd.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

Result<BenchReport> Measured(const BenchOptions& options) {
  double before = 0;
  auto report = RunBench(options, [&](double share, const std::string& text) {
    EXPECT_GT(share, before) << text;
    EXPECT_LE(share, 1) << text;
    EXPECT_THAT(text, HasSubstr(" objects, "));
    before = share;
  });
  EXPECT_DOUBLE_EQ(before, report.ok() ? 1 : before);
  return report;
}

BenchOptions SmallOptions() {
  BenchOptions options;
  options.scenes = {"hurricane", "brownian"};
  options.object_counts = {40, 60};
  options.frames = 3;
  options.warmup = 2;
  options.arms = {"SAP", "Grid"};
  return options;
}

TEST(RunBench, HasARowForEachCellArmAndCountOfThreads) {
  BenchOptions options = SmallOptions();
  options.thread_counts = {1, 2};
  const auto report = Measured(options);
  ASSERT_TRUE(report.ok()) << report.status().message();
  std::vector<std::string> cells;
  for (const BenchCell& cell : report->cells) {
    cells.push_back(cell.scene + std::to_string(cell.object_count));
  }
  EXPECT_THAT(cells, ElementsAre("hurricane40", "hurricane60", "brownian40", "brownian60"));
  ASSERT_EQ(report->rows.size(), 4U * 2 * 2);
  for (size_t i = 0; i < report->rows.size(); ++i) {
    const BenchRow& row = report->rows[i];
    EXPECT_EQ(row.cell, i / 4) << i;
    EXPECT_EQ(row.name, i % 4 < 2 ? "Grid" : "SAP") << i;
    EXPECT_EQ(row.family, row.name) << i;
    EXPECT_EQ(row.thread_count, i % 2 + 1) << i;
    EXPECT_EQ(row.kind, ContestantKind::kArm) << i;
  }
}

TEST(RunBench, HasARowForEachInstructionSetTheBestFirst) {
  BenchOptions options = SmallOptions();
  const auto usable = SimdTargets();
  // The option lists the sets in the wrong order and one of them twice.
  options.simd.assign(usable.rbegin(), usable.rend());
  options.simd.emplace_back(usable.back());
  const auto report = Measured(options);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(std::ranges::equal(report->options.simd, usable));
  ASSERT_EQ(report->rows.size(), 4 * 2 * usable.size());
  for (size_t i = 0; i < report->rows.size(); ++i) {
    EXPECT_EQ(report->rows[i].simd, usable[i % usable.size()]) << i;
    EXPECT_EQ(report->rows[i].difference, "") << i;
  }
  EXPECT_EQ(report->machine.simd_target, usable.front());
  EXPECT_EQ(SimdTarget(), usable.front());
}

TEST(RunBench, MeasuresOnlyTheInstructionSetsThatAreNamed) {
  BenchOptions options = SmallOptions();
  const std::string least(SimdTargets().back());
  options.simd = {least};
  const auto report = Measured(options);
  ASSERT_TRUE(report.ok());
  EXPECT_THAT(report->options.simd, ElementsAre(least));
  EXPECT_EQ(report->rows.size(), 4U * 2);
  EXPECT_EQ(report->machine.simd_target, least);
  ASSERT_TRUE(UseSimdTarget(SimdTargets().front()).ok());
}

TEST(RunBench, MeasuresTheChosenInstructionSetUnlessAnotherIsAskedFor) {
  const std::string least(SimdTargets().back());
  ASSERT_TRUE(UseSimdTarget(least).ok());
  const auto report = Measured(SmallOptions());
  EXPECT_EQ(SimdTarget(), least);
  ASSERT_TRUE(UseSimdTarget(SimdTargets().front()).ok());
  ASSERT_TRUE(report.ok());
  EXPECT_THAT(report->options.simd, ElementsAre(least));
  for (const BenchRow& row : report->rows) EXPECT_EQ(row.simd, least);
}

TEST(RunBench, CountsOnlyTheFramesAfterTheWarmUp) {
  const auto report = Measured(SmallOptions());
  ASSERT_TRUE(report.ok());
  for (const BenchRow& row : report->rows) {
    EXPECT_EQ(row.frame_count, 3U);
    EXPECT_EQ(row.step_ms.size(), 5U);
    EXPECT_EQ(row.first_step, 1U);
    EXPECT_LE(row.ms_min, row.ms_median);
    EXPECT_LE(row.ms_median, row.ms_p99);
    EXPECT_EQ(row.ms_min, *std::min_element(row.step_ms.begin() + 2, row.step_ms.end()));
    EXPECT_EQ(row.note, "");
  }
}

TEST(RunBench, AllArmsFindTheSamePairs) {
  BenchOptions options = SmallOptions();
  options.arms = {"all"};
  options.object_counts = {200};
  const auto report = Measured(options);
  ASSERT_TRUE(report.ok());
  ASSERT_EQ(report->rows.size(), 2 * BroadPhaseNames().size());
  for (const BenchRow& row : report->rows) {
    EXPECT_EQ(row.difference, "") << row.name;
    EXPECT_EQ(row.pairs_mean, report->rows[row.cell * BroadPhaseNames().size()].pairs_mean);
    EXPECT_TRUE(row.aabb_checks_mean) << row.name;
    EXPECT_GE(*row.bytes_with_pairs, *row.bytes) << row.name;
  }
  EXPECT_FALSE(AnyDiffers(*report));
  EXPECT_TRUE(report->speedups.empty()) << "there are no peers";
}

TEST(RunBench, TheDocumentHasTheRowsOfTheReport) {
  const auto report = Measured(SmallOptions());
  ASSERT_TRUE(report.ok());
  std::ostringstream out;
  PrintBenchJson(*report, out);
  const json document = json::parse(out.str());
  ASSERT_EQ(document["rows"].size(), report->rows.size());
  for (size_t i = 0; i < report->rows.size(); ++i) {
    const json& row = document["rows"][i];
    EXPECT_EQ(row["scene"], report->cells[report->rows[i].cell].scene);
    EXPECT_EQ(row["objects"], report->cells[report->rows[i].cell].object_count);
    EXPECT_EQ(row["arm"], report->rows[i].name);
    EXPECT_EQ(row["ms_median"], report->rows[i].ms_median);
    EXPECT_EQ(row["frames"], 3);
  }
  EXPECT_EQ(document["warmup"], 2);
  EXPECT_EQ(document["machine"]["libraries"].size(), 1U) << "Highway alone";
}

TEST(RunBench, NamesWhatThereIsNot) {
  BenchOptions options = SmallOptions();
  options.arms = {"Octree"};
  EXPECT_EQ(Measured(options).status().code(), StatusCode::kNotFound);
  options = SmallOptions();
  options.scenes = {"brownian", "nowhere"};
  EXPECT_THAT(Measured(options).status().message(), HasSubstr("nowhere"));
  options = SmallOptions();
  const std::string before(SimdTarget());
  options.simd = {std::string(SimdTargets().back()), "mmx"};
  EXPECT_EQ(Measured(options).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(SimdTarget(), before);
}

TEST(AnyDiffers, IsTrueWhereOneRowHasADifference) {
  BenchReport report;
  report.rows.resize(3);
  EXPECT_FALSE(AnyDiffers(report));
  report.rows[1].note = "stopped by the cap";
  EXPECT_FALSE(AnyDiffers(report));
  report.rows[2].difference = "step 1: other pairs";
  EXPECT_TRUE(AnyDiffers(report));
}

}  // namespace
}  // namespace sweepstake::cli
