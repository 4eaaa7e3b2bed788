// Tests `sweepstake-lab replay --log`, which derives the decisions of an audit log again and finds
// changed rows.
#include "tests/laboratory/replay/replay_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/terminal.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/embedded/study_maker.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/tests/lab_command.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

struct Log {
  std::string text;
  uint64_t decision_count = 0;
  // Returns where the last row begins.
  size_t last_row() const { return text.rfind("\n0,") + 1; }
};

std::vector<decision::AuditRow> RowsOf(const Log& log) {
  std::vector<decision::AuditRow> rows(1);
  for (decision::AuditCsvReader reader(log.text); reader.Next(rows.back());) rows.emplace_back();
  rows.pop_back();
  return rows;
}

std::string CsvOf(const std::vector<decision::AuditRow>& rows) {
  std::string text = decision::AuditHeader() + "\n";
  for (const decision::AuditRow& row : rows) text += decision::AuditLines(row) + "\n";
  return text;
}

// Returns the log of a game in virtual time at time scale 100. Frames on the second arm take three
// times as long as on the first.
Log PlayLog(const std::string& policy, uint32_t frame_count = 300) {
  Log log{.text = EmbeddedDecider::AuditHeader() + "\n"};
  EmbeddedOptions options;
  options.policy = policy;
  options.time_scale = 100;
  options.on_audit_row = [&](std::string_view row) { log.text.append(row).append("\n"); };
  const std::vector<std::string> arms = {"SAP", "KDTree"};
  const auto decider = StudyMaker{decision::StudyPolicies()}.MakeDecider(
      options, arms, std::vector<uint32_t>{1, 1}, 0);
  EXPECT_TRUE(decider.ok()) << decider.status().message();
  uint64_t now_ns = 0;
  FrameSample sample{};
  sample.object_count = 1000;
  for (uint32_t frame = 0; frame < frame_count; ++frame) {
    sample.frame_index = frame;
    sample.frame_time_ns = sample.arm == 0 ? 5'000'000 : 15'000'000;
    sample.detection_time_ns = sample.frame_time_ns / 2;
    now_ns += sample.frame_time_ns;
    (*decider)->Observe(std::vector{sample}, now_ns);
    const auto command = (*decider)->Poll(now_ns);
    if (!command || command->arm == sample.arm) continue;
    sample.arm = command->arm;
    ++sample.switch_epoch;
  }
  log.decision_count = (*decider)->decision_count();
  EXPECT_GT(log.decision_count, 40U);
  return log;
}

class ReplayLogTest : public testing::Test {
 protected:
  CommandRun Replay(const std::string& text, bool as_json = false) {
    std::ofstream(path_, std::ios::binary) << text;
    return ReplayFile(path_.string(), as_json);
  }
  static CommandRun ReplayFile(const std::string& path, bool as_json = false) {
    return RunLabCommand("replay --log " + path + (as_json ? " --json" : ""));
  }

  const test_support::TemporaryDirectory folder_;
  const std::filesystem::path path_ = folder_.path() / "decisions.csv";
};

TEST_F(ReplayLogTest, DerivesEveryDecisionAgain) {
  for (const std::string policy : {"paper", "default", "random"}) {
    const Log log = PlayLog(policy);
    const CommandRun outcome = Replay(log.text);
    EXPECT_EQ(outcome.exit_code, kDone) << outcome.out;
    EXPECT_EQ(outcome.out, std::to_string(log.decision_count) +
                               " decisions in 1 segment re-derived, all equal\n");
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(ReplayLogTest, KnowsTheAblationsOfTheLaboratory) {
  const CommandRun outcome = Replay(PlayLog("adaptive-without-gate").text);
  EXPECT_EQ(outcome.exit_code, kDone) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("all equal"));
}

TEST_F(ReplayLogTest, GroupsLargeNumbers) {
  const Log log = PlayLog("random", 6000);
  ASSERT_GT(log.decision_count, 1000U);
  std::string grouped = std::to_string(log.decision_count);
  grouped.insert(grouped.size() - 3, ",");
  EXPECT_THAT(Replay(log.text).out, StartsWith(grouped + " decisions in 1 segment"));
}

TEST_F(ReplayLogTest, JsonIsOneDocumentWithTheCounts) {
  const Log log = PlayLog("paper");
  const CommandRun outcome = Replay(log.text, /*as_json=*/true);
  EXPECT_EQ(outcome.exit_code, kDone);
  const json document = json::parse(outcome.out);
  EXPECT_EQ(document["command"], "replay");
  EXPECT_EQ(document["log"], path_.string());
  EXPECT_EQ(document["sessions"], 1);
  EXPECT_EQ(document["segments"], 1);
  EXPECT_EQ(document["rows"], RowsOf(log).size());
  EXPECT_EQ(document["decisions"], log.decision_count);
  EXPECT_EQ(document["equal"], true);
  EXPECT_TRUE(document["difference"].is_null());
}

// A game with another seed would have made different decisions.
TEST_F(ReplayLogTest, AnEditedSetupIsADifference) {
  std::vector<decision::AuditRow> rows = RowsOf(PlayLog("paper"));
  rows.at(0).setup->setup.seed = 2;
  const CommandRun outcome = Replay(CsvOf(rows));
  EXPECT_EQ(outcome.exit_code, kCheckFailed);
  EXPECT_THAT(outcome.out,
              HasSubstr("re-derived, then a row differs (or another build wrote the log):\n"));
}

TEST_F(ReplayLogTest, NamesTheLineOfAnEdit) {
  const Log log = PlayLog("paper");
  std::vector<decision::AuditRow> rows = RowsOf(log);
  ++rows.back().log_hash;
  const std::string text = CsvOf(rows);
  const auto line = std::count(log.text.begin(), log.text.begin() + log.last_row(), '\n') + 1;
  const CommandRun plain = Replay(text);
  EXPECT_EQ(plain.exit_code, kCheckFailed);
  EXPECT_THAT(plain.out, AllOf(HasSubstr("then a row differs (or another build wrote the log):\n"),
                               HasSubstr(std::to_string(line)), HasSubstr("log_hash")));
  const CommandRun as_json = Replay(text, /*as_json=*/true);
  EXPECT_EQ(as_json.exit_code, kCheckFailed);
  const json document = json::parse(as_json.out);
  EXPECT_EQ(document["equal"], false);
  EXPECT_EQ(document["difference"]["line"], line);
  EXPECT_EQ(document["difference"]["session"], "embedded");
  EXPECT_EQ(document["difference"]["segment"], 1);
  EXPECT_EQ(document["difference"]["column"], "log_hash");
  EXPECT_NE(document["difference"]["message"], "");
}

TEST_F(ReplayLogTest, ALogThatIsCutOffWithinARowIsADifference) {
  const Log log = PlayLog("paper");
  const CommandRun outcome = Replay(log.text.substr(0, log.text.size() - 40));
  EXPECT_EQ(outcome.exit_code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("cut off"));
}

TEST_F(ReplayLogTest, TheLastRowsMayBeMissing) {
  const Log log = PlayLog("paper");
  const CommandRun outcome = Replay(log.text.substr(0, log.last_row()));
  EXPECT_EQ(outcome.exit_code, kDone) << outcome.out;
  EXPECT_THAT(outcome.out, StartsWith(std::to_string(log.decision_count - 1) + " decisions"));
}

TEST_F(ReplayLogTest, SaysWhatCannotBeDerivedBecauseRowsBeforeItAreMissing) {
  const Log log = PlayLog("paper");
  std::vector<decision::AuditRow> rows = RowsOf(log);
  rows.at(0) = decision::MissingRow("embedded", 1, 1);
  const std::string text = CsvOf(rows);
  const CommandRun outcome = Replay(text);
  EXPECT_EQ(outcome.exit_code, kDone) << outcome.out;
  EXPECT_THAT(
      outcome.out,
      AllOf(StartsWith("0 decisions in 0 segments re-derived, all equal\n"),
            HasSubstr(std::to_string(log.decision_count) +
                      " decisions in 1 segment cannot be re-derived: earlier rows are missing")));
  const json document = json::parse(Replay(text, /*as_json=*/true).out);
  EXPECT_EQ(document["decisions"], 0);
  EXPECT_EQ(document["incomplete_segments"], 1);
  EXPECT_EQ(document["underived_decisions"], log.decision_count);
}

TEST_F(ReplayLogTest, AMissingRowIsADifference) {
  std::vector<decision::AuditRow> rows = RowsOf(PlayLog("paper"));
  rows.erase(rows.begin() + 8);
  const json document = json::parse(Replay(CsvOf(rows), /*as_json=*/true).out);
  EXPECT_EQ(document["equal"], false);
  EXPECT_EQ(document["difference"]["row"], 10);
}

TEST_F(ReplayLogTest, AFileThatIsNoLogIsADifferenceInItsFirstLine) {
  EXPECT_EQ(Replay("").exit_code, kCheckFailed);
  for (const std::string text : {"a,b\n1,2\n", "\xff\xfe", "{\"rows\": []}\n"}) {
    const CommandRun outcome = Replay(text, /*as_json=*/true);
    EXPECT_EQ(outcome.exit_code, kCheckFailed) << text;
    const json document = json::parse(outcome.out);
    EXPECT_EQ(document["decisions"], 0) << text;
    EXPECT_EQ(document["difference"]["line"], 1) << text;
  }
}

TEST_F(ReplayLogTest, ALogWithoutDecisionsIsBadUsage) {
  const CommandRun outcome = Replay(EmbeddedDecider::AuditHeader() + "\n");
  EXPECT_EQ(outcome.exit_code, kBadUsage);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr("decisions.csv contains no decisions"));
}

TEST_F(ReplayLogTest, WhatCannotBeReadIsBadUsage) {
  for (const std::filesystem::path& path : {folder_.path() / "missing.csv", folder_.path()}) {
    const CommandRun outcome = ReplayFile(path.string());
    EXPECT_EQ(outcome.exit_code, kBadUsage) << path;
    EXPECT_EQ(outcome.out, "") << path;
    EXPECT_THAT(outcome.err, HasSubstr(path.string() + " cannot be read"));
  }
}

}  // namespace
}  // namespace sweepstake::cli
