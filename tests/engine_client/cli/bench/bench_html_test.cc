// The page of `sweepstake bench --report`, made of a report with everything in it that can occur.
#include "engine_client/cli/bench/bench_html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/engine_client/cli/html/well_formed.h"

namespace sweepstake::cli {
namespace {

using test_support::FirstFlaw;
using testing::HasSubstr;
using testing::Not;

BenchRow Row(size_t cell, ContestantKind kind, const std::string& family, const std::string& name,
             double ms_median) {
  BenchRow row;
  row.cell = cell;
  row.kind = kind;
  row.family = family;
  row.name = name;
  row.frame_count = 40;
  row.ms_median = ms_median;
  row.ms_mean = ms_median * 1.1;
  row.ms_min = ms_median * 0.9;
  row.ms_p99 = ms_median * 3;
  row.pairs_mean = 1234;
  if (kind == ContestantKind::kArm) {
    row.aabb_checks_mean = 56'789;
    row.bytes = 400'000;
    row.bytes_with_pairs = 500'000;
  }
  return row;
}

BenchRatio Ratio(size_t cell, RatioKind kind, const std::string& ours, const std::string& other,
                 double value, double goal) {
  BenchRatio ratio;
  ratio.cell = cell;
  ratio.kind = kind;
  ratio.family = ours;
  ratio.ours = ours;
  ratio.other = other;
  ratio.value = value;
  ratio.goal = goal;
  const bool large =
      kind == RatioKind::kFamily || kind == RatioKind::kOverall || kind == RatioKind::kThreads;
  ratio.met = large ? value >= goal : value <= goal;
  return ratio;
}

BenchReport SmallReport() {
  BenchReport report;
  report.machine.date_utc = "2026-01-31T12:00:00Z";
  report.machine.cpu = "Some <CPU> & Co";
  report.machine.core_count = 2;
  report.machine.compiler = "gcc 12";
  report.machine.simd_target = "AVX3";
  report.machine.libraries = {{"Highway", "1.0.3"}, {"Bullet", "3.24"}};
  report.cells = {{"suite-b", 1000, false}, {"suite-b", 10000, false}};
  for (size_t cell = 0; cell < 2; ++cell) {
    report.rows.push_back(Row(cell, ContestantKind::kArm, "Grid", "Grid", cell == 0 ? 0.03 : 0.3));
    report.rows.push_back(Row(cell, ContestantKind::kArm, "DBVT", "DBVT", cell == 0 ? 0.06 : 0.9));
  }
  return report;
}

BenchReport FullReport() {
  BenchReport report = SmallReport();
  report.options.peers = true;
  report.options.thread_counts = {1, 2};
  report.machine.absent_peers = {"ODE: libode-dev"};
  report.cells.push_back({"/tmp/<b>\"evil\" & 'odd'\xff.aabbs", 77, true});
  report.rows.push_back(Row(2, ContestantKind::kArm, "Grid", "Grid", 0.01));
  for (size_t cell = 0; cell < 3; ++cell) {
    report.rows.push_back(Row(cell, ContestantKind::kPeer, "DBVT", "Bullet DBVT", 0.5));
  }
  BenchRow two = Row(1, ContestantKind::kArm, "Grid", "Grid", 0.2);
  two.thread_count = 2;
  report.rows.push_back(two);
  BenchRow wrong = Row(0, ContestantKind::kPeer, "Grid", "Wrong", 0.4);
  wrong.difference = "frame 3: (1, 2) is missing";
  report.rows.push_back(wrong);
  BenchRow absent = Row(1, ContestantKind::kPeer, "SAP", "Slow", 0);
  absent.frame_count = 0;
  absent.note = "would take longer than 5 s";
  report.rows.push_back(absent);
  report.ratios = {Ratio(0, RatioKind::kOverall, "Grid", "Bullet DBVT", 16.7, 5),
                   Ratio(1, RatioKind::kOverall, "Grid", "Bullet DBVT", 1.67, 5),
                   Ratio(0, RatioKind::kFamily, "DBVT", "Bullet DBVT", 8.33, 7),
                   Ratio(1, RatioKind::kSpike, "Grid", "median", 3, 2),
                   Ratio(1, RatioKind::kGrowth, "Grid", "at 1,000", 1, 2),
                   Ratio(1, RatioKind::kMemory, "Grid", "12 MB", 0.4, 1)};
  report.ratios.push_back(report.ratios.front());
  report.ratios.back().other = "Published peer";
  report.ratios.back().derived_through = "Bullet DBVT";
  return report;
}

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(BenchHtml, IsWellFormedWhateverNamesAreInIt) {
  const std::string html =
      BenchHtml(FullReport(), "sweepstake bench --scene '<x>&'", "{\"rows\":[]}");
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, Not(HasSubstr("<b>\"evil\"")));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;&quot;evil&quot; &amp; &#39;odd&#39;\uFFFD.aabbs"));
  EXPECT_THAT(html, HasSubstr("Some &lt;CPU&gt; &amp; Co"));
  EXPECT_THAT(html, HasSubstr("sweepstake bench --scene &#39;&lt;x&gt;&amp;&#39;"));
}

TEST(BenchHtml, LoadsNothing) {
  const std::string html = BenchHtml(FullReport(), "sweepstake bench", "{\"rows\":[]}");
  for (const char* loading : {"://", "src=", "@import", "url(", "<link"}) {
    EXPECT_THAT(html, Not(HasSubstr(loading)));
  }
}

TEST(BenchHtml, HasEveryRowAlsoOfThoseThatTookNoPart) {
  const BenchReport report = FullReport();
  const std::string html = BenchHtml(report, "sweepstake bench", "{\"rows\":[]}");
  const std::string rows = html.substr(html.find("<table id=\"rows\""));
  // One line is the header, and one is above each cell's rows.
  EXPECT_EQ(Count(rows.substr(0, rows.find("</table>")), "<tr>"),
            1 + report.cells.size() + report.rows.size());
  EXPECT_THAT(rows, HasSubstr("would take longer than 5 s"));
  EXPECT_THAT(rows, HasSubstr("frame 3: (1, 2) is missing"));
}

TEST(BenchHtml, SaysInWordsWhichGoalsAreMet) {
  const std::string html = BenchHtml(FullReport(), "sweepstake bench", "{\"rows\":[]}");
  EXPECT_THAT(html, HasSubstr("16.7×</b><small class=\"verdict met\">✓ met (≥ 5×)"));
  EXPECT_THAT(html, HasSubstr("1.67×</b><small class=\"verdict missed\">✗ missed (≥ 5×)"));
  EXPECT_THAT(html, HasSubstr("✗ missed (≤ 2×)"));
  EXPECT_THAT(html, HasSubstr("✓ met (≤ 12 MB)"));
  EXPECT_THAT(html, HasSubstr("✗ 2 of 3 met"));
}

TEST(BenchHtml, HeadlineIsOfMeasuredPeersOnly) {
  BenchReport report = FullReport();
  report.ratios.back().value = 99;
  const std::string html = BenchHtml(report, "sweepstake bench", "{\"rows\":[]}");
  EXPECT_THAT(html, HasSubstr("<b>1.67–16.7×</b>"));
  EXPECT_THAT(html, HasSubstr("Published peer, through Bullet DBVT"));
}

TEST(BenchHtml, WarnsOfWrongPairsAndNamesWhoIsAbsent) {
  const std::string html = BenchHtml(FullReport(), "sweepstake bench", "{\"rows\":[]}");
  EXPECT_THAT(html, HasSubstr("✗ Not all pairs were right"));
  EXPECT_THAT(html, HasSubstr("✗ wrong pairs"));
  EXPECT_THAT(html, HasSubstr("ODE: libode-dev"));
}

TEST(BenchHtml, DrawsLinesForSeveralCountsAndARankingForOne) {
  const std::string html = BenchHtml(FullReport(), "sweepstake bench", "{\"rows\":[]}");
  EXPECT_THAT(html, HasSubstr("<figure class=\"chart\" id=\"chart-1\">"));
  EXPECT_THAT(html, HasSubstr("<figure class=\"chart ranges\" id=\"chart-2\">"));
}

TEST(BenchHtml, ShowsThreadsOnlyWhereThereWereSeveral) {
  const std::string html = BenchHtml(FullReport(), "sweepstake bench", "{\"rows\":[]}");
  EXPECT_THAT(html, HasSubstr("Grid (2 threads)"));
  EXPECT_THAT(html, HasSubstr("<table id=\"threads\">"));
  EXPECT_THAT(BenchHtml(SmallReport(), "sweepstake bench", "{}"), Not(HasSubstr("id=\"threads\"")));
}

TEST(BenchHtml, StandsWithoutPeersRatiosOrRows) {
  const std::string html = BenchHtml(SmallReport(), "sweepstake bench", "{\"rows\":[]}");
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("No peers took part"));
  EXPECT_EQ(FirstFlaw(BenchHtml(BenchReport(), "sweepstake bench", "{}")), "");
}

TEST(BenchHtml, EmbedsTheRowsForPrograms) {
  const std::string html =
      BenchHtml(SmallReport(), "sweepstake bench", R"({"rows":["</script>"]})");
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr(R"(id="bench-json">{"rows":["\u003c/script>"]}</script>)"));
}

}  // namespace
}  // namespace sweepstake::cli
