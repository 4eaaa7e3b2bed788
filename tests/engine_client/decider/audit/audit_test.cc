// The audit log replays bit for bit, and a replay finds the place of any change to the log.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/field_text.h"
#include "engine_client/decider/audit/rederive.h"
#include "tests/engine_client/decider/audit/audited_game.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

using Rows = std::vector<AuditRow>;
using Lines = std::vector<std::vector<std::string>>;

Rows LogOf(uint64_t seed, std::string_view policy, int steps) {
  AuditFile file;
  AuditedGame(AuditedSetup(seed, policy), &file).Run(steps);
  return file.rows;
}

// Returns the cells of each line of a CSV file.
Lines LinesOf(const std::string& csv) {
  Lines lines;
  text::CsvReader reader(csv);
  for (std::vector<std::string> cells; reader.Next(cells);) lines.push_back(cells);
  EXPECT_EQ(reader.problem(), "");
  return lines;
}

std::string TextOf(const Lines& lines) {
  std::string text;
  for (const auto& line : lines) {
    for (size_t i = 0; i < line.size(); ++i) text::AppendCsv(text += i > 0 ? "," : "", line[i]);
    text += '\n';
  }
  return text;
}

std::string CsvOf(const Rows& rows) {
  std::string text = AuditHeader() + "\n";
  for (const AuditRow& row : rows) text += AuditLines(row) + "\n";
  return text;
}

size_t ColumnOf(std::string_view name) {
  const auto& columns = AuditColumns();
  return static_cast<size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
}

std::string ProblemOf(const Rows& rows) {
  const AuditReport report = Rederive(rows);
  return report.difference ? report.difference->Text() : "";
}

std::string ProblemOf(const std::string& csv) {
  const AuditReport report = RederiveCsv(csv);
  return report.difference ? report.difference->Text() : "";
}

Rows::iterator FirstTick(Rows& rows) {
  return std::find_if(rows.begin(), rows.end(),
                      [](const AuditRow& row) { return row.kind == AuditKind::kTick; });
}

TEST(AuditLog, OfEveryPolicyReplaysBitForBit) {
  for (const std::string_view policy : PolicyNames(StudyPolicies())) {
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      const Rows rows = LogOf(seed, policy, 1'500);
      const AuditReport report = Rederive(rows, StudyPolicies());
      ASSERT_FALSE(report.difference) << policy << ": " << report.difference->Text();
      EXPECT_EQ(report.row_count, rows.size());
      EXPECT_GT(report.decision_count, 100u);
    }
  }
}

TEST(AuditLog, ContainsEveryKindOfRow) {
  std::set<AuditKind> kinds;
  for (const AuditRow& row : LogOf(1, "paper", 2'000)) kinds.insert(row.kind);
  EXPECT_EQ(kinds.size(), 7u) << "all but missing and admin";
}

TEST(AuditLog, HasARowWithTheResultOfEachDecision) {
  AuditFile file;
  AuditedGame game(AuditedSetup(3, "paper"), &file);
  game.Run(500);
  size_t next = 0;
  for (const AuditRow& row : file.rows) {
    if (!row.decision) continue;
    ASSERT_LT(next, game.decisions().size());
    const Decision& decision = game.decisions()[next++];
    EXPECT_EQ(row.decision->id, decision.record.decision_id);
    EXPECT_EQ(row.decision->active_arm, game.session().arms()[decision.record.active_arm]);
    EXPECT_EQ(row.decision->reward, decision.record.reward);
    EXPECT_EQ(row.command_id.has_value(), decision.command.has_value());
  }
  EXPECT_EQ(next, game.decisions().size());
}

TEST(AuditLog, DoesNotChangeDecisions) {
  AuditFile file;
  AuditedGame logged(AuditedSetup(5, "paper"), &file);
  AuditedGame silent(AuditedSetup(5, "paper"), nullptr);
  logged.Run(1'000);
  silent.Run(1'000);
  ASSERT_EQ(logged.decisions().size(), silent.decisions().size());
  for (size_t i = 0; i < logged.decisions().size(); ++i) {
    EXPECT_EQ(logged.decisions()[i].record.draws, silent.decisions()[i].record.draws);
    EXPECT_EQ(logged.decisions()[i].record.posteriors, silent.decisions()[i].record.posteriors);
  }
}

TEST(AuditLog, OfASessionThatContinuesAfterARestartHasTwoSegments) {
  AuditFile file;
  AuditedGame first(AuditedSetup(7, "paper"), &file);
  first.Run(400);
  SessionSetup setup = AuditedSetup(7, "paper");
  const auto posteriors = first.session().posteriors();
  setup.priors.assign(posteriors.begin(), posteriors.end());
  setup.decision_count = first.session().decision_count();
  setup.explored_arm_count = first.session().explored_arm_count();
  AuditedGame(setup, &file, 2).Run(400);
  const AuditReport report = Rederive(file.rows);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  EXPECT_EQ(report.session_count, 1u);
  EXPECT_EQ(report.segment_count, 2u);
}

TEST(AuditLog, WithoutItsLastRowsIsStillValid) {
  for (Rows rows = LogOf(1, "paper", 400); !rows.empty(); rows.pop_back())
    ASSERT_EQ(ProblemOf(rows), "");
}

TEST(AuditLog, IsTheSameAfterItWasACsvFile) {
  const Rows rows = LogOf(1, "default", 400);
  const std::string csv = CsvOf(rows);
  Rows read(1);
  for (AuditCsvReader reader(csv); reader.Next(read.back());) read.emplace_back();
  read.pop_back();
  EXPECT_EQ(CsvOf(read), csv);
  EXPECT_EQ(ProblemOf(csv), "");
  EXPECT_EQ(ProblemOf(read), "");
  ASSERT_EQ(read.size(), rows.size());
  EXPECT_EQ(read[0].setup->origin.scene, rows[0].setup->origin.scene);
  EXPECT_EQ(read[0].setup->setup.arms, rows[0].setup->setup.arms);
}

TEST(AuditLog, AcceptsWindowsLineEndings) {
  std::string text;
  for (const auto& line : LinesOf(CsvOf(LogOf(1, "paper", 100)))) {
    text += TextOf({line});
    text.insert(text.size() - 1, "\r");
  }
  EXPECT_EQ(ProblemOf(text), "");
}

TEST(AuditLog, AnEditOfAnyCellIsFoundInItsRow) {
  const Lines lines = LinesOf(CsvOf(LogOf(1, "paper", 40)));
  for (size_t line = 1; line < lines.size(); line += 1 + line / 8) {
    for (size_t column = 0; column < lines[line].size(); ++column) {
      Lines edited = lines;
      std::string& cell = edited[line][column];
      cell =
          cell.empty() ? "1" : cell.substr(0, cell.size() - 1) + (cell.back() == '1' ? '2' : '1');
      const AuditReport report = RederiveCsv(TextOf(edited));
      ASSERT_TRUE(report.difference) << "line " << line << ", column " << AuditColumns()[column];
      EXPECT_EQ(report.row_count + 1, std::stoul(lines[line][ColumnOf("row")]))
          << "line " << line << ", column " << AuditColumns()[column] << ": "
          << report.difference->Text();
    }
  }
}

TEST(AuditLog, AnEditedOutputIsNamedWithBothValues) {
  Rows rows = LogOf(1, "paper", 400);
  const auto tick = FirstTick(rows);
  const double beta = std::exchange(tick->decision->posteriors[2].beta, 7);
  const AuditReport report = Rederive(rows);
  ASSERT_TRUE(report.difference);
  EXPECT_EQ(report.difference->session, "session of 1");
  EXPECT_EQ(report.difference->segment, 1u);
  EXPECT_EQ(report.difference->row, tick->row);
  EXPECT_EQ(report.difference->column, "decision_posteriors_beta");
  EXPECT_EQ(report.difference->message,
            "the log has 7, but deriving the row again gives " + FieldText(beta));
}

TEST(AuditLog, MissingAndSwappedRowsAreReported) {
  const Rows rows = LogOf(1, "paper", 200);
  Rows missing = rows;
  missing.erase(missing.begin() + 4);
  EXPECT_NE(ProblemOf(missing).find("row 6, row should be 5"), std::string::npos)
      << ProblemOf(missing);
  Rows exchanged = rows;
  std::swap(exchanged[4], exchanged[5]);
  EXPECT_NE(ProblemOf(exchanged).find("row 6, row should be 5"), std::string::npos);
  Rows headless = rows;
  headless.erase(headless.begin());
  EXPECT_NE(ProblemOf(headless).find("first rows are missing"), std::string::npos);
}

// Returns the rows, with `count` rows from number `first` on replaced by one row that marks them as
// missing.
Rows WithMissing(Rows rows, size_t first, size_t count) {
  const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(first) - 1;
  rows.erase(begin + 1, begin + static_cast<std::ptrdiff_t>(count));
  *begin = MissingRow(begin->session, 1, first);
  return rows;
}

TEST(AuditLog, WithAMissingRowReplaysUpToItAndIsCheckedByHashesAfterIt) {
  const Rows rows = LogOf(1, "paper", 1'500);
  ASSERT_GT(rows.size(), 100u);
  const AuditReport whole = Rederive(rows);
  EXPECT_EQ(whole.incomplete_segment_count, 0u);
  for (const size_t first : {1u, 2u, 50u}) {
    for (const size_t count : {1u, 20u}) {
      const AuditReport report = Rederive(WithMissing(rows, first, count));
      ASSERT_FALSE(report.difference) << report.difference->Text();
      EXPECT_EQ(report.row_count, rows.size() - count);
      EXPECT_EQ(report.session_count, 1u);
      EXPECT_EQ(report.segment_count, first == 1 ? 0u : 1u);
      EXPECT_EQ(report.incomplete_segment_count, 1u);
      EXPECT_LE(report.decision_count, first);
      EXPECT_LE(report.decision_count + report.underived_decision_count, whole.decision_count);
      EXPECT_GE(report.decision_count + report.underived_decision_count,
                whole.decision_count - count);
    }
  }
}

TEST(AuditLog, AnEditAfterMissingRowsIsFound) {
  const Rows rows = WithMissing(LogOf(1, "paper", 150), 5, 3);
  ASSERT_GT(rows.size(), 10u);
  const std::string csv = CsvOf(rows);
  ASSERT_EQ(ProblemOf(csv), "");
  const Lines lines = LinesOf(csv);
  const auto line = std::find_if(lines.begin(), lines.end(), [](const auto& cells) {
    return cells[ColumnOf("row")] == "10" && cells[0] == "0";
  });
  for (size_t column = 0; column < line->size(); ++column) {
    Lines edited = lines;
    edited[static_cast<size_t>(line - lines.begin())][column] += "1";
    EXPECT_EQ(RederiveCsv(TextOf(edited)).row_count, 6u) << AuditColumns()[column];
    EXPECT_NE(ProblemOf(TextOf(edited)), "") << AuditColumns()[column];
  }
  Rows swapped = rows;
  std::swap(swapped[7], swapped[8]);
  EXPECT_NE(ProblemOf(swapped).find("rows are missing or out of order"), std::string::npos);
  Rows not_missing = rows;
  not_missing[4].time_ns = 1;
  EXPECT_NE(ProblemOf(not_missing).find("its other columns are not empty"), std::string::npos);
}

TEST(AuditLog, ATruncatedLineIsReported) {
  std::string text = CsvOf(LogOf(1, "paper", 200));
  text.resize(text.rfind("\n0,") + 40);
  EXPECT_NE(ProblemOf(text).find("is it cut off?"), std::string::npos) << ProblemOf(text);
}

TEST(AuditLog, OtherFilesAreRejected) {
  EXPECT_EQ(ProblemOf(std::string()), "the file is empty");
  EXPECT_EQ(ProblemOf(std::string("frame,arm\n1,2\n")),
            "line 1: this is not the header of an audit log of this version");
  EXPECT_EQ(ProblemOf(AuditHeader() + "\n"), "");
}

TEST(AuditLog, ATickBeforeItIsDueOrAfterTheEndOfTimeIsRejected) {
  Rows rows = LogOf(1, "paper", 200);
  const auto tick = FirstTick(rows);
  tick->time_ns = 5;
  EXPECT_NE(ProblemOf(rows).find("time_ns is too early: the next tick is due at"),
            std::string::npos)
      << ProblemOf(rows);
  for (const auto time_ns : {std::optional<int64_t>(INT64_MAX), std::optional<int64_t>()}) {
    tick->time_ns = time_ns;
    EXPECT_NE(ProblemOf(rows).find("time_ns is empty or not from -2^62 to 2^62"),
              std::string::npos);
  }
}

TEST(AuditLog, RunsOfArmsThatAreNotThereAndImpossibleSumsAreRefused) {
  const Rows rows = LogOf(1, "paper", 200);
  const Lines lines = LinesOf(CsvOf(rows));
  const auto tick = std::find_if(lines.begin(), lines.end(), [](const auto& cells) {
    return cells[ColumnOf("kind")] == "tick";
  });
  const auto problem_with = [&](std::string_view column, const std::string& value) {
    Lines edited = lines;
    edited[static_cast<size_t>(tick - lines.begin())][ColumnOf(column)] = value;
    return ProblemOf(TextOf(edited));
  };
  EXPECT_NE(problem_with("runs_active_arm", "9").find("has an arm or switch epoch"),
            std::string::npos);
  for (const char* wrong : {"-1", "inf", "nan"}) {
    EXPECT_NE(problem_with("runs_active_window_time_ns", wrong).find("has a sum that is negative"),
              std::string::npos)
        << wrong;
  }
  EXPECT_NE(problem_with("runs_active_window_time_ns", "x").find("is not readable: x"),
            std::string::npos);
}

TEST(AuditLog, WithRandomBytesCausesNoCrash) {
  RandomStream random(11, RandomPurpose::kChoice, 0, 0);
  const std::string log = CsvOf(LogOf(1, "default", 60));
  const std::string_view bytes = "0123456789, \"\n\r-.einf\x80";
  for (int i = 0; i < 3'000; ++i) {
    std::string text = log;
    for (uint32_t edits = 1 + random.NextBelow(3); edits > 0; --edits) {
      const uint32_t at = random.NextBelow(static_cast<uint32_t>(text.size()));
      const char byte = bytes[random.NextBelow(static_cast<uint32_t>(bytes.size()))];
      switch (random.NextBelow(3)) {
        case 0:
          text[at] = byte;
          break;
        case 1:
          text.insert(at, 1, byte);
          break;
        default:
          text.erase(at, 1 + random.NextBelow(20));
      }
    }
    RederiveCsv(text);
  }
}

TEST(AuditLog, WithAbsurdInputsCausesNoCrash) {
  RandomStream random(12, RandomPurpose::kChoice, 0, 0);
  const Lines lines = LinesOf(CsvOf(LogOf(2, "default", 60)));
  const std::string values[] = {"0",
                                "18446744073709551615",
                                "-9223372036854775808",
                                "1e308",
                                "nan",
                                "-inf",
                                "4294967295",
                                "0.5",
                                "",
                                "-0"};
  for (int i = 0; i < 2'000; ++i) {
    Lines edited = lines;
    auto& line = edited[1 + random.NextBelow(static_cast<uint32_t>(lines.size() - 1))];
    line[random.NextBelow(static_cast<uint32_t>(line.size()))] =
        values[random.NextBelow(std::size(values))];
    RederiveCsv(TextOf(edited));
  }
}

TEST(AuditCsv, CellsWithCommasQuotesAndLineBreaksAreReadBack) {
  const Lines rows = {{"a,b", "\"quoted\"", "two\nlines", "carriage\rreturn", "", "ä€"}, {"plain"}};
  EXPECT_EQ(LinesOf(TextOf(rows)), rows);
}

TEST(AuditCsv, AnUnclosedQuoteIsAnError) {
  std::vector<std::string> cells;
  text::CsvReader reader("a,\"b\nc");
  EXPECT_FALSE(reader.Next(cells));
  EXPECT_EQ(reader.problem(), "a quoted cell has no closing quote");
}

}  // namespace
}  // namespace sweepstake::decision
