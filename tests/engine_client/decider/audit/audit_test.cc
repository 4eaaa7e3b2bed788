// The audit log replays bit for bit, and a replay finds the place of any change to the log.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/cells.h"
#include "engine_client/decider/audit/csv.h"
#include "engine_client/decider/audit/rederive.h"
#include "tests/engine_client/decider/audit/audited_game.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows RowsOf(const std::string& csv) {
  Rows rows;
  CsvReader reader(csv);
  for (std::vector<std::string> cells; reader.Next(cells);) rows.push_back(cells);
  EXPECT_EQ(reader.problem(), "");
  return rows;
}

std::string TextOf(const Rows& rows) {
  std::string text;
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      AppendCsv(text, row[i]);
    }
    text += '\n';
  }
  return text;
}

std::string& CellOf(std::vector<std::string>& row, AuditColumn column) {
  return row[static_cast<size_t>(column)];
}

AuditFile LogOf(uint64_t seed, std::string_view policy, int steps) {
  AuditFile file;
  AuditedGame(AuditedSetup(seed, policy), &file).Run(steps);
  return file;
}

std::string ProblemOf(const std::string& csv) {
  const AuditReport report = Rederive(csv);
  return report.difference ? report.difference->Text() : "";
}

TEST(AuditLog, OfEveryPolicyReplaysBitForBit) {
  for (const std::string_view policy : PolicyNames(StudyPolicies())) {
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      const AuditFile file = LogOf(seed, policy, 1'500);
      const AuditReport report = Rederive(file.text, StudyPolicies());
      ASSERT_FALSE(report.difference) << policy << ": " << report.difference->Text();
      EXPECT_EQ(report.row_count, file.row_count);
      EXPECT_GT(report.decision_count, 100u);
    }
  }
}

TEST(AuditLog, ContainsEveryKindOfRow) {
  std::set<std::string> kinds;
  for (auto& row : RowsOf(LogOf(1, "paper", 2'000).text))
    kinds.insert(CellOf(row, AuditColumn::kKind));
  for (const char* kind : {"setup", "tick", "bail-out", "switch", "refusal", "mode", "order"})
    EXPECT_TRUE(kinds.contains(kind)) << kind;
}

TEST(AuditLog, HasARowWithTheResultOfEachDecision) {
  AuditFile file;
  AuditedGame game(AuditedSetup(3, "paper"), &file);
  game.Run(500);
  Rows rows = RowsOf(file.text);
  size_t next = 0;
  for (auto& row : rows) {
    if (CellOf(row, AuditColumn::kKind) != "tick" && CellOf(row, AuditColumn::kKind) != "bail-out")
      continue;
    ASSERT_LT(next, game.decisions().size());
    const Decision& decision = game.decisions()[next++];
    EXPECT_EQ(CellOf(row, AuditColumn::kDecisionId), std::to_string(decision.record.decision_id));
    EXPECT_EQ(CellOf(row, AuditColumn::kActiveArm),
              game.session().arms()[decision.record.active_arm]);
    EXPECT_EQ(CellOf(row, AuditColumn::kReward).empty(), !decision.record.reward);
    if (decision.record.reward) {
      EXPECT_EQ(std::stod(CellOf(row, AuditColumn::kReward)), *decision.record.reward);
    }
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
  const AuditReport report = Rederive(file.text);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  EXPECT_EQ(report.session_count, 1u);
  EXPECT_EQ(report.segment_count, 2u);
}

TEST(AuditLog, WithoutItsLastRowsIsStillValid) {
  Rows rows = RowsOf(LogOf(1, "paper", 400).text);
  while (rows.size() > 1) {
    rows.pop_back();
    ASSERT_EQ(ProblemOf(TextOf(rows)), "");
  }
}

TEST(AuditLog, AcceptsWindowsLineEndings) {
  const Rows rows = RowsOf(LogOf(1, "paper", 100).text);
  std::string text;
  for (const auto& row : rows) {
    std::string line = TextOf({row});
    line.pop_back();
    text += line + "\r\n";
  }
  EXPECT_EQ(ProblemOf(text), "");
}

TEST(AuditLog, AnEditOfAnyCellIsFoundInItsRow) {
  const Rows rows = RowsOf(LogOf(1, "paper", 150).text);
  for (size_t row = 1; row < rows.size(); row += 1 + row / 8) {
    for (size_t column = 0; column < rows[row].size(); ++column) {
      Rows edited = rows;
      std::string& cell = edited[row][column];
      cell =
          cell.empty() ? "1" : cell.substr(0, cell.size() - 1) + (cell.back() == '1' ? '2' : '1');
      const AuditReport report = Rederive(TextOf(edited));
      ASSERT_TRUE(report.difference) << "row " << row << ", column " << kAuditColumnNames[column];
      EXPECT_EQ(report.row_count, row - 1) << kAuditColumnNames[column];
      EXPECT_NE(report.difference->Text().find(", "), std::string::npos);
    }
  }
}

TEST(AuditLog, AnEditedOutputIsNamedWithBothValues) {
  Rows rows = RowsOf(LogOf(1, "paper", 400).text);
  const auto tick = std::find_if(rows.begin(), rows.end(), [](auto& row) {
    return CellOf(row, AuditColumn::kKind) == "tick";
  });
  const std::string derived = std::exchange(CellOf(*tick, AuditColumn::kOutcome), "wrong");
  const AuditReport report = Rederive(TextOf(rows));
  ASSERT_TRUE(report.difference);
  EXPECT_EQ(report.difference->session, "session of 1");
  EXPECT_EQ(report.difference->segment, "1");
  EXPECT_EQ(report.difference->row, CellOf(*tick, AuditColumn::kRow));
  EXPECT_EQ(report.difference->column, "outcome");
  EXPECT_EQ(report.difference->message, "the log has wrong, derived again it is " + derived);
}

TEST(AuditLog, MissingAndSwappedRowsAreReported) {
  const Rows rows = RowsOf(LogOf(1, "paper", 200).text);
  Rows missing = rows;
  missing.erase(missing.begin() + 5);
  EXPECT_NE(ProblemOf(TextOf(missing)).find("row 6, row comes where row 5 should"),
            std::string::npos)
      << ProblemOf(TextOf(missing));
  Rows exchanged = rows;
  std::swap(exchanged[5], exchanged[6]);
  EXPECT_NE(ProblemOf(TextOf(exchanged)).find("row 6, row comes where row 5 should"),
            std::string::npos);
  Rows headless = rows;
  headless.erase(headless.begin() + 1);
  EXPECT_NE(ProblemOf(TextOf(headless)).find("first rows are missing"), std::string::npos);
}

// Returns the rows, with `count` rows from number `first` on replaced by one `missing` row.
Rows WithMissing(const Rows& rows, size_t first, size_t count) {
  Rows missing = rows;
  missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(first),
                missing.begin() + static_cast<std::ptrdiff_t>(first + count));
  missing.insert(missing.begin() + static_cast<std::ptrdiff_t>(first),
                 RowsOf(MissingRow(rows[1][0], 1, first)).front());
  return missing;
}

TEST(AuditLog, WithAMissingRowReplaysUpToItAndIsCheckedByHashesAfterIt) {
  const AuditFile file = LogOf(1, "paper", 1'500);
  const Rows rows = RowsOf(file.text);
  ASSERT_GT(rows.size(), 100u);
  const AuditReport whole = Rederive(file.text);
  EXPECT_EQ(whole.incomplete_segment_count, 0u);
  for (const size_t first : {1u, 2u, 50u}) {
    for (const size_t count : {1u, 20u}) {
      const AuditReport report = Rederive(TextOf(WithMissing(rows, first, count)));
      ASSERT_FALSE(report.difference) << report.difference->Text();
      EXPECT_EQ(report.row_count, file.row_count - count);
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
  const Rows rows = WithMissing(RowsOf(LogOf(1, "paper", 400).text), 5, 3);
  ASSERT_GT(rows.size(), 10u);
  ASSERT_EQ(ProblemOf(TextOf(rows)), "");
  for (size_t column = 0; column < rows[8].size(); ++column) {
    Rows edited = rows;
    edited[8][column] += "1";
    EXPECT_EQ(Rederive(TextOf(edited)).row_count, 6u) << kAuditColumnNames[column];
    EXPECT_NE(ProblemOf(TextOf(edited)), "") << kAuditColumnNames[column];
  }
  Rows swapped = rows;
  std::swap(swapped[8], swapped[9]);
  EXPECT_NE(ProblemOf(TextOf(swapped)).find("comes where row"), std::string::npos);
  Rows told_twice = rows;
  CellOf(told_twice[5], AuditColumn::kTimeNs) = "1";
  EXPECT_NE(ProblemOf(TextOf(told_twice)).find("has values in its other cells"), std::string::npos);
}

TEST(AuditLog, ATruncatedLineIsReported) {
  std::string text = LogOf(1, "paper", 200).text;
  text.resize(text.size() - 3);
  EXPECT_NE(ProblemOf(text).find("log_hash does not match"), std::string::npos) << ProblemOf(text);
  text.resize(text.rfind('\n') + 40);
  EXPECT_NE(ProblemOf(text).find("is it cut off?"), std::string::npos) << ProblemOf(text);
}

TEST(AuditLog, OtherFilesAreRejected) {
  EXPECT_EQ(ProblemOf(""), "line 0: the file is empty");
  EXPECT_EQ(ProblemOf("frame,arm\n1,2\n"),
            "line 1: the header is not that of an audit log of this version");
  EXPECT_EQ(ProblemOf(AuditHeader() + "\n"), "");
}

TEST(AuditLog, ATickBeforeItIsDueOrAfterTheEndOfTimeIsRejected) {
  Rows rows = RowsOf(LogOf(1, "paper", 200).text);
  const auto tick = std::find_if(rows.begin(), rows.end(), [](auto& row) {
    return CellOf(row, AuditColumn::kKind) == "tick";
  });
  CellOf(*tick, AuditColumn::kTimeNs) = "5";
  EXPECT_NE(ProblemOf(TextOf(rows)).find("time_ns is earlier than the next tick"),
            std::string::npos)
      << ProblemOf(TextOf(rows));
  CellOf(*tick, AuditColumn::kTimeNs) = "9223372036854775807";
  EXPECT_NE(ProblemOf(TextOf(rows)).find("time_ns is out of the range of a clock"),
            std::string::npos);
}

// The goal is at most 1.5 kB for 7 arms, with all cells that a policy with a gate and a diagnosis
// fills.
TEST(AuditLog, ARowOfSevenArmsIsSmall) {
  AuditFile file;
  AuditedGame game(AuditedSetup(1, "default"), &file);
  game.Run(4'000);
  EXPECT_LT(static_cast<double>(file.text.size()) / static_cast<double>(file.row_count), 1'500);
}

TEST(AuditLog, WithRandomBytesCausesNoCrash) {
  RandomStream random(11, RandomPurpose::kChoice, 0, 0);
  const std::string log = LogOf(1, "default", 60).text;
  const std::string_view bytes = "0123456789,:; \"\n\r-.einf\\=\x80";
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
    Rederive(text);
  }
}

TEST(AuditLog, WithAbsurdInputsCausesNoCrash) {
  RandomStream random(12, RandomPurpose::kChoice, 0, 0);
  const Rows rows = RowsOf(LogOf(2, "default", 60).text);
  const std::string_view values[] = {"0",
                                     "18446744073709551615",
                                     "-9223372036854775808",
                                     "1e308",
                                     "nan",
                                     "-inf",
                                     "4294967295",
                                     "0.5",
                                     "",
                                     "-0"};
  for (int i = 0; i < 3'000; ++i) {
    Rows edited = rows;
    auto& row = edited[1 + random.NextBelow(static_cast<uint32_t>(rows.size() - 1))];
    std::string& cell = row[random.NextBelow(static_cast<uint32_t>(row.size()))];
    const std::string_view value = values[random.NextBelow(std::size(values))];
    // Replaces one number of a cell that has several.
    size_t begin = cell.empty() ? 0 : random.NextBelow(static_cast<uint32_t>(cell.size()));
    begin = cell.find_last_of(":;= ,", begin) == std::string::npos
                ? 0
                : cell.find_last_of(":;= ,", begin) + 1;
    const size_t end = std::min(cell.find_first_of(":; ,", begin), cell.size());
    cell.replace(begin, end - begin, value);
    Rederive(TextOf(edited));
  }
}

TEST(AuditCsv, CellsWithCommasQuotesAndLineBreaksAreReadBack) {
  const Rows rows = {{"a,b", "\"quoted\"", "two\nlines", "carriage\rreturn", "", "ä€"}, {"plain"}};
  EXPECT_EQ(RowsOf(TextOf(rows)), rows);
}

TEST(AuditCsv, AnUnclosedQuoteIsAnError) {
  std::vector<std::string> cells;
  CsvReader reader("a,\"b\nc");
  EXPECT_FALSE(reader.Next(cells));
  EXPECT_EQ(reader.problem(), "a quoted cell has no closing quote");
}

FrameSample FrameOf(uint32_t arm, uint32_t epoch, uint64_t frame_time_ns = 0) {
  FrameSample frame;
  frame.arm = arm;
  frame.switch_epoch = epoch;
  frame.frame_time_ns = frame_time_ns;
  return frame;
}

TEST(AuditRuns, AreReadBackCompletely) {
  ArmRuns runs(3, ArmRun(1, 4, 0));
  runs.Find(FrameOf(1, 4), 0)->Observe(FrameOf(1, 4, 5), 7);
  runs.Find(FrameOf(1, 4), 0)->Observe(FrameOf(1, 4, 6), 7);
  runs.Find(FrameOf(2, 5), 9)->Observe(FrameOf(2, 4, 8), 7);
  std::string text;
  AppendRuns(text, runs);
  const auto parsed = ParseRuns(text, 3);
  ASSERT_TRUE(parsed);
  std::string again;
  AppendRuns(again, *parsed);
  EXPECT_EQ(again, text);
  EXPECT_EQ(parsed->active().window().frame_count(), 2u);
  EXPECT_EQ(parsed->later()->arm(), 2u);
}

TEST(AuditRuns, WithUnknownArmsOrImpossibleSumsAreRejected) {
  std::string text;
  AppendRuns(text, ArmRuns(2, ArmRun(1, 4, 9)));
  ASSERT_EQ(text, "0 1:4:0:0:0:9:0:0:0:0:0:0:0:0:0:0:0:0:0");
  EXPECT_TRUE(ParseRuns(text, 2));
  EXPECT_FALSE(ParseRuns(text, 1));
  EXPECT_FALSE(ParseRuns(text + " 1", 2));
  EXPECT_FALSE(ParseRuns(text + ":0", 2));
  EXPECT_FALSE(ParseRuns("", 2));
  for (const char* wrong : {"-1", "inf", "nan", "x", ""}) {
    EXPECT_FALSE(ParseRuns("0 1:4:0:0:0:9:0:0:0:" + std::string(wrong) + ":0:0:0:0:0:0:0:0:0", 2))
        << wrong;
  }
}

}  // namespace
}  // namespace sweepstake::decision
