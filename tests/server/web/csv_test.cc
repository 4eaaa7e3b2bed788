// Tests the cells of CSV files, and the tables that are made from rows of the audit log.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "server/web/csv/csv_lines.h"
#include "server/web/csv/csv_tables.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/history.pb.h"

namespace sweepstake::web {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string CellOf(const std::string& text) {
  CsvLines lines;
  lines.Text(text);
  return lines.Take();
}

TEST(CsvLinesTest, CellsWithCommasQuotesAndLineBreaksAreQuoted) {
  CsvLines lines;
  for (const char* text : {"plain", "a,b", "say \"hi\"", "two\nlines", ""}) lines.Text(text);
  lines.End();
  EXPECT_EQ(lines.Take(), "plain,\"a,b\",\"say \"\"hi\"\"\",\"two\nlines\",\r\n");
  EXPECT_EQ(lines.Take(), "");
}

TEST(CsvLinesTest, ATextThatASpreadsheetWouldRunGetsAnApostrophe) {
  for (const char* text :
       {"=1+1", "+1", "-1", "@cmd", "\tx", ";=1", " =1", "\u00a0=1", "＝1", "＋1", "－1", "＠x"})
    EXPECT_EQ(CellOf(text), std::string("'") + text);
  EXPECT_EQ(CellOf("\rx"), "\"'\rx\"");
  for (const char* text : {"a=1", "'=1", "ｘ", "1-1"}) EXPECT_EQ(CellOf(text), text);
}

TEST(CsvLinesTest, NumbersAreExactAndTimesAreInIso8601) {
  CsvLines lines;
  lines.Number(0.1);
  lines.Number(-1);
  lines.Number(std::numeric_limits<uint64_t>::max());
  lines.Number(1.0 / 3);
  lines.Number(std::optional<double>());
  lines.Time(1'772'373'909'125);
  lines.Time(0);
  lines.Nothing(2);
  EXPECT_EQ(lines.Take(),
            "0.1,-1,18446744073709551615,0.3333333333333333,,2026-03-01T14:05:09.125Z,,,");
}

v1::ExportDecisionsResponse Part() {
  v1::ExportDecisionsResponse part;
  v1::SegmentSetup& setup = *part.add_setups();
  setup.set_session_id("a");
  setup.set_segment(1);
  setup.mutable_setup()->set_unix_start_ms(1'772'373'909'000);
  setup.mutable_setup()->set_start_ns(5'000'000);
  setup.mutable_setup()->add_arms("=SAP");
  setup.mutable_setup()->add_arms("Grid");
  v1::AuditRow& row = *part.add_rows();
  row.set_session("a");
  row.set_segment(1);
  row.set_row(2);
  row.set_kind(v1::AUDIT_KIND_TICK);
  row.set_time_ns(130'000'000);
  v1::AuditDecision& decision = *row.mutable_decision();
  decision.set_id(7);
  decision.set_active_arm("Grid");
  decision.set_outcome(v1::DECISION_OUTCOME_HELD_COOLDOWN);
  for (const double alpha : {1.5, 3.0}) {
    decision.add_posteriors()->set_alpha(alpha);
    decision.mutable_posteriors()->rbegin()->set_beta(2);
    decision.add_best_probability(alpha / 4.5);
  }
  v1::AuditWindow& window = *row.mutable_runs()->mutable_active()->mutable_window();
  window.set_frame_count(4);
  window.set_ordinary_frame_count(2);
  window.set_time_ns(66e6);
  window.set_ordinary_detection_ns(5e3);
  window.set_check_count(10);
  window.set_peak_bytes(4096);
  return part;
}

TEST(CsvTablesTest, WindowsHavePlainNumbersAndTheirUnitsInTheHeader) {
  const auto table = FindCsv("windows")->make();
  EXPECT_EQ(table->Header(),
            "time,session,decision,algorithm,frames,mean frame time (ms),"
            "mean detection time (µs),AABB checks per frame,peak memory (bytes)\r\n");
  v1::ExportDecisionsResponse part = Part();
  EXPECT_EQ(table->Lines(part), "2026-03-01T14:05:09.125Z,a,7,Grid,4,16.5,2.5,2.5,4096\r\n");
  // The next response has no setup of its own, because it continues the segment.
  part.clear_setups();
  v1::AuditRun& run = *part.mutable_rows(0)->mutable_runs()->mutable_active();
  *run.mutable_new_frames() = run.window();
  run.clear_window();
  EXPECT_THAT(table->Lines(part), StartsWith("2026-03-01T14:05:09.125Z,a,7,Grid,4,16.5"));
  run.clear_new_frames();
  EXPECT_EQ(table->Lines(part), "") << "a window without frames";
}

TEST(CsvTablesTest, PosteriorsHaveALinePerAlgorithm) {
  EXPECT_EQ(FindCsv("posteriors")->make()->Lines(Part()),
            "2026-03-01T14:05:09.125Z,a,7,'=SAP,1.5,2,0.3333333333333333\r\n"
            "2026-03-01T14:05:09.125Z,a,7,Grid,3,2,0.6666666666666666\r\n");
}

TEST(CsvTablesTest, DecisionsOfASegmentWithoutSetupHaveNoTime) {
  const auto table = FindCsv("decisions")->make();
  v1::ExportDecisionsResponse part = Part();
  EXPECT_THAT(table->Lines(part), HasSubstr(",tick,7,Grid,,held cooldown,"));
  part.clear_setups();
  part.mutable_rows(0)->set_segment(2);
  EXPECT_THAT(table->Lines(part), StartsWith(",,,a,2,2,tick,7,Grid"));
}

TEST(CsvTablesTest, EveryLineHasACellPerColumn) {
  const auto table = FindCsv("decisions")->make();
  v1::ExportDecisionsResponse part = Part();
  const auto commas = [](const std::string& text) {
    return std::count(text.begin(), text.end(), ',');
  };
  EXPECT_EQ(commas(table->Lines(part)), commas(table->Header()));
  part.mutable_rows(0)->mutable_decision()->mutable_gate();
  part.mutable_rows(0)->mutable_decision()->set_leader("Grid");
  EXPECT_EQ(commas(table->Lines(part)), commas(table->Header()));
}

TEST(CsvTablesTest, TheHistoryHasALinePerPointAndAlgorithm) {
  v1::GetHistoryResponse part;
  v1::HistorySeries& series = *part.add_series();
  series.set_project("game");
  series.set_scene("harbour");
  series.set_reward_version(3);
  v1::HistoryPoint& point = *series.add_points();
  point.set_unix_ms(1'772'373'909'000);
  point.set_end_unix_ms(1'772'373'924'000);
  point.set_frame_count(4);
  point.set_ran_us(10);
  point.set_initial_us(12);
  point.set_switch_count(1);
  point.set_session_count(2);
  point.mutable_native_bytes()->add_bucket_steps(0);
  point.mutable_native_bytes()->add_counts(4);
  v1::ArmHistory& arm = *point.add_arms();
  arm.set_arm("SAP");
  arm.set_active_frame_count(5);
  arm.set_frame_count(4);
  arm.set_would_take_us(14);
  point.add_arms()->set_arm("Grid");
  point.mutable_activity()->add_arms("SAP");
  v1::RegimeArm& belief = *point.mutable_activity()->mutable_total()->add_arms();
  belief.set_best_probability(0.5F);
  belief.set_cost_us(2);
  const auto table = FindCsv("history")->make();
  EXPECT_EQ(table->Lines(part),
            "2026-03-01T14:05:09.000Z,2026-03-01T14:05:24.000Z,game,harbour,,3,,,SAP,5,3.5,0.5,2,4,"
            "2.5,3,1,2,,,,,,,0\r\n"
            "2026-03-01T14:05:09.000Z,2026-03-01T14:05:24.000Z,game,harbour,,3,,,Grid,0,,,,4,"
            "2.5,3,1,2,,,,,,,0\r\n");
  const std::string header = table->Header();
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), 24);
}

TEST(CsvTablesTest, AnUnknownTableIsNull) { EXPECT_EQ(FindCsv("priors"), nullptr); }

}  // namespace
}  // namespace sweepstake::web
