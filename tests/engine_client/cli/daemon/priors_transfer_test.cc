// Checks the requests and output of `sweepstake priors` against a service with scripted answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "tests/engine_client/cli/command_run.h"
#include "tests/engine_client/cli/daemon/fake_daemon_services.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::FakeDaemonServices;
using test_support::FileText;
using test_support::TemporaryDirectory;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

PriorRecord SomeRecord(uint64_t sequence) {
  return {.key = {.project = "p",
                  .scene = "s",
                  .measured_by = "lane",
                  .arm = "SAP",
                  .backend_version = 3,
                  .machine_class = "m",
                  .reward_version = 2},
          .source_id = "session-" + std::to_string(sequence),
          .source_sequence = sequence,
          .evidence = {1.5, 2.25, 4, 1},
          .build = "1.2",
          .last_seen_unix_s = 1'700'000'000};
}

TEST(ImportPriors, SplitsTheRecordsIntoMessagesOfTwoHundred) {
  FakeDaemonServices daemon;
  std::vector<PriorRecord> records;
  for (uint64_t i = 1; i <= 450; ++i) records.push_back(SomeRecord(i));
  const auto result = ImportPriors({daemon.address()}, records);
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_THAT(daemon.priors.imported_sizes.get(), ElementsAre(200, 200, 50));
  EXPECT_EQ(daemon.priors.imported->back().source_sequence(), 450U);
  EXPECT_EQ(result->applied_count, 449U);
  EXPECT_EQ(result->unchanged_count, 1U);
}

TEST(ImportPriors, ReturnsTheReasonWhenTheDaemonRefuses) {
  FakeDaemonServices daemon;
  daemon.priors.import_status =
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "record 0 has no arm");
  const auto result = ImportPriors({daemon.address()}, std::vector{SomeRecord(1)});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(result.status().message(), "record 0 has no arm");
}

TEST(PriorsCommand, AChangeWhoseCallBrokeOffMayHaveBeenMade) {
  FakeDaemonServices daemon;
  daemon.priors.import_status = grpc::Status(grpc::StatusCode::UNAVAILABLE, "Socket closed");
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  ASSERT_TRUE(WriteWhole(file, FormatPriors(std::vector{SomeRecord(1)})).ok());
  const CommandRun run = RunCommand("priors import --in " + file + " --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, AllOf(HasSubstr("the call to " + daemon.address() + " broke off"),
                             HasSubstr("the change may have been made, and `sweepstake priors "
                                       "list` shows whether it was")));
}

TEST(ExportPriors, KeepsEveryFieldInAnImportAndAnExport) {
  FakeDaemonServices daemon;
  const PriorRecord record = SomeRecord(9);
  ASSERT_TRUE(ImportPriors({daemon.address()}, std::vector{record}).ok());
  daemon.priors.parts->resize(2);
  *daemon.priors.parts->at(1).add_records() = daemon.priors.imported->at(0);
  const auto exported = ExportPriors({daemon.address()}, "p", "s");
  ASSERT_TRUE(exported.ok()) << exported.status().message();
  ASSERT_EQ(exported->size(), 1U);
  EXPECT_EQ(FormatPriors(*exported), FormatPriors(std::vector{record}));
  EXPECT_EQ(daemon.priors.export_request.get().project(), "p");
  EXPECT_EQ(daemon.priors.export_request.get().scene(), "s");
}

TEST(PriorsCommand, ExportsAFileThatImportReads) {
  FakeDaemonServices daemon;
  ASSERT_TRUE(ImportPriors({daemon.address()}, std::vector{SomeRecord(1), SomeRecord(2)}).ok());
  daemon.priors.parts->resize(1);
  for (const v1::PriorRecord& record : daemon.priors.imported.get()) {
    *daemon.priors.parts->at(0).add_records() = record;
  }
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  const std::string at = " --daemon " + daemon.address();
  EXPECT_EQ(RunCommand("priors export --out " + file + at).out, file + ": 2 records\n");
  daemon.priors.imported->clear();
  EXPECT_EQ(RunCommand("priors import --in " + file + at).out,
            file +
                ": 2 records; new or newer: 1, already known: 1\n"
                "they are in quarantine, and count after `sweepstake priors promote`\n");
  EXPECT_EQ(daemon.priors.imported->size(), 2U);
  EXPECT_FALSE(daemon.priors.promotes);
  EXPECT_EQ(RunCommand("priors import --promote --in " + file + at).out,
            file + ": 2 records; new or newer: 3, already known: 1\n");
  EXPECT_TRUE(daemon.priors.promotes);
}

TEST(PriorsCommand, CountsRecordsThatAreStoredUnderAnotherScene) {
  FakeDaemonServices daemon;
  PriorRecord renamed = SomeRecord(2);
  renamed.key.scene = "renamed";
  ASSERT_TRUE(ImportPriors({daemon.address()}, std::vector{SomeRecord(1), SomeRecord(2)}).ok());
  daemon.priors.parts->resize(1);
  for (const v1::PriorRecord& record : daemon.priors.imported.get()) {
    *daemon.priors.parts->at(0).add_records() = record;
  }
  const auto result = ImportPriors({daemon.address()}, std::vector{SomeRecord(1), renamed});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->absent_count, 1U);
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  ASSERT_TRUE(WriteWhole(file, FormatPriors(std::vector{renamed})).ok());
  const CommandRun run = RunCommand("priors import --in " + file + " --daemon " + daemon.address());
  EXPECT_THAT(run.out, HasSubstr("1 of these are not stored under their project and scene"));
}

TEST(PriorsCommand, AnEmptyExportGivesExitCodeOneAndKeepsTheFile) {
  FakeDaemonServices daemon;
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  std::ofstream(file) << "good";
  const CommandRun run =
      RunCommand("priors export --scene nosuch --out " + file + " --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("the daemon has no matching records"));
  EXPECT_EQ(FileText(file), "good");
}

TEST(PriorsCommand, ARevocationIsAPreviewUntilItIsConfirmed) {
  FakeDaemonServices daemon;
  daemon.priors.revoke_response->set_source_count(2);
  daemon.priors.revoke_response->set_record_count(9);
  daemon.priors.revoke_response->set_window_count(70);
  const std::string command =
      "priors revoke --project p --source s --build 1.3 --token-id 7 --since 10 --until 20 "
      "--daemon " +
      daemon.address();
  EXPECT_EQ(
      RunCommand(command).out,
      "2 sources with 9 records of 70 windows and visits would be revoked; add --yes to do it\n");
  const v1::RevokePriorsRequest asked = daemon.priors.revoke_request.get();
  EXPECT_TRUE(asked.preview());
  EXPECT_EQ(asked.sources().project(), "p");
  EXPECT_EQ(asked.sources().source_id(), "s");
  EXPECT_EQ(asked.sources().build(), "1.3");
  EXPECT_EQ(asked.sources().token_id(), 7);
  EXPECT_EQ(asked.sources().unix_from_s(), 10);
  EXPECT_EQ(asked.sources().unix_until_s(), 20);
  const auto done = nlohmann::json::parse(RunCommand(command + " --yes --json").out);
  EXPECT_FALSE(daemon.priors.revoke_request->preview());
  daemon.priors.revoke_response->set_source_count(1);
  EXPECT_EQ(RunCommand(command + " --yes").out,
            "1 source with 9 records of 70 windows and visits was revoked\n");
  EXPECT_EQ(done["revoked"], true);
  EXPECT_EQ(done["sources"], 2);
  EXPECT_EQ(done["records"], 9);
  EXPECT_EQ(done["windows"], 70);
  EXPECT_GT(daemon.priors.patience_s, 60) << "a large store needs longer than the usual deadline";
}

TEST(PriorsCommand, ACommandThatMatchesNothingSaysSo) {
  FakeDaemonServices daemon;
  const std::string at = " --daemon " + daemon.address();
  EXPECT_THAT(
      RunCommand("priors revoke --build nope --yes" + at).out,
      HasSubstr(
          "no session matches, or all that match are revoked already; `sweepstake audit list`"));
  EXPECT_THAT(RunCommand("priors revoke --source nope --yes" + at).out,
              HasSubstr("if its evidence arrives later, it will not count"));
  EXPECT_THAT(RunCommand("priors revoke --source known --build nope --yes" + at).out,
              Not(HasSubstr("if its evidence arrives later")));
  EXPECT_THAT(RunCommand("priors promote" + at).out, HasSubstr("no record in quarantine matches"));
  for (const std::string& command : {std::string("priors revoke"), std::string("priors promote")}) {
    const CommandRun run = RunCommand(command + " --since 10 --until 5" + at);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr("--until is before --since"));
  }
}

TEST(PriorsCommand, SummedEvidenceOfOldSessionsIsRevokedAlthoughItHasNoSource) {
  FakeDaemonServices daemon;
  daemon.priors.revoke_response->set_record_count(2);
  EXPECT_THAT(RunCommand("priors revoke --build 1.0 --daemon " + daemon.address()).out,
              HasSubstr("0 sources with 2 records"));
}

TEST(PriorsCommand, AnExportOfSumsCountsTheRecordsInQuarantine) {
  FakeDaemonServices daemon;
  v1::ExportPriorsResponse part;
  v1::PriorRecord& record = *part.add_records();
  record.set_project("p");
  record.set_scene("s");
  record.set_arm("SAP");
  record.set_backend_version(1);
  record.set_reward_version(3);
  record.set_source_id("session");
  record.set_source_sequence(1);
  record.set_is_quarantined(true);
  daemon.priors.parts = std::vector{part};
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  const std::string command = "priors export --out " + file + " --daemon " + daemon.address();
  for (const char* const selection : {"", " --project p"}) {
    const CommandRun none = RunCommand(command + " --sums" + selection);
    EXPECT_EQ(none.exit_code, 1);
    EXPECT_THAT(none.err,
                AllOf(HasSubstr("p.json was not changed"), HasSubstr("1 record in quarantine")));
  }
  v1::PriorRecord& counts = *part.add_records();
  counts = record;
  counts.set_is_quarantined(false);
  daemon.priors.parts = std::vector{part};
  EXPECT_EQ(RunCommand(command + " --sums").out,
            file +
                ": 1 sum of builds\n"
                "1 record in quarantine, not part of any sum; `sweepstake priors promote` makes "
                "quarantined records count\n");
  EXPECT_THAT(RunCommand(command + " --sums --json").out, HasSubstr("\"left_waiting\": 1"));
  EXPECT_THAT(RunCommand(command + " --json").out, HasSubstr("\"left_waiting\": 0"))
      << "the file contains the quarantined records";
}

TEST(PriorsCommand, APromotionIsAPreviewUntilItIsConfirmed) {
  FakeDaemonServices daemon;
  daemon.priors.promote_response->set_source_count(2);
  daemon.priors.promote_response->set_record_count(9);
  daemon.priors.promote_response->set_window_count(70);
  daemon.priors.promote_response->set_scene_count(3);
  const std::string command =
      "priors promote --project p --source s --build 1.3 --daemon " + daemon.address();
  EXPECT_EQ(RunCommand(command).out,
            "2 sources with 9 records of 70 windows and visits for 3 scenes would be promoted; add "
            "--yes to do it\n");
  const v1::PromotePriorsRequest asked = daemon.priors.promote_request.get();
  EXPECT_TRUE(asked.preview());
  EXPECT_EQ(asked.sources().project(), "p");
  EXPECT_EQ(asked.sources().source_id(), "s");
  EXPECT_EQ(asked.sources().build(), "1.3");
  const auto done = nlohmann::json::parse(RunCommand(command + " --yes --json").out);
  EXPECT_FALSE(daemon.priors.promote_request->preview());
  EXPECT_EQ(done["promoted"], true);
  EXPECT_EQ(done["sources"], 2);
  EXPECT_EQ(done["records"], 9);
  EXPECT_EQ(done["windows"], 70);
  EXPECT_EQ(done["scenes"], 3);
  EXPECT_GT(daemon.priors.patience_s, 60);
}

TEST(PriorsCommand, APreviewNamesTheScenesWhoseLeaderWouldChange) {
  FakeDaemonServices daemon;
  v1::LeaderChanges changes;
  changes.set_scene_count(2);
  v1::LeaderChange& change = *changes.add_scenes();
  change.set_project("arcade");
  change.set_scene("harbour");
  change.set_machine_class("desktop");
  change.set_reward_version(3);
  change.set_next_arm("SAP");
  daemon.priors.revoke_response->set_source_count(1);
  *daemon.priors.revoke_response->mutable_leader_changes() = changes;
  daemon.priors.promote_response->set_source_count(1);
  *daemon.priors.promote_response->mutable_leader_changes() = changes;
  for (const char* action : {"revoke --build 1.3", "promote"}) {
    const std::string command = std::string("priors ") + action + " --daemon " + daemon.address();
    EXPECT_THAT(RunCommand(command).out,
                HasSubstr("another arm would be the leader of 2 scenes:\n"
                          "  arcade / harbour on desktop, reward version 3: SAP instead of none\n"
                          "  and others\n"));
    const auto told = nlohmann::json::parse(RunCommand(command + " --json").out)["leader_changes"];
    EXPECT_EQ(told["count"], 2);
    EXPECT_EQ(told["scenes"][0]["scene"], "harbour");
    EXPECT_EQ(told["scenes"][0]["next_arm"], "SAP");
  }
}

TEST(PriorsCommand, AListShowsQuarantinedEvidenceSeparately) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages->resize(1);
  PriorRecord record = SomeRecord(1);
  ASSERT_TRUE(ImportPriors({daemon.address()}, std::vector{record}).ok());
  v1::ExportPriorsResponse part;
  *part.add_records() = daemon.priors.imported->at(0);
  part.mutable_records(0)->set_is_quarantined(true);
  daemon.priors.parts->push_back(part);
  const std::string command = "priors list --scene s --daemon " + daemon.address();
  EXPECT_THAT(RunCommand(command).out,
              AllOf(HasSubstr("Imports in quarantine, which count after"),
                    HasSubstr("p/s on m in build 1.2 (in quarantine), 1 source\n")));
  EXPECT_TRUE(daemon.priors.export_request->quarantined_only());
  EXPECT_EQ(daemon.priors.export_request->scene(), "s");
  const auto entry = nlohmann::json::parse(RunCommand(command + " --json").out)["quarantined"][0];
  EXPECT_EQ(entry["quarantined"], true);
  EXPECT_EQ(entry["build"], "1.2");
}

TEST(PriorsCommand, AnExportThatCannotBeWrittenGivesExitCodeTwo) {
  FakeDaemonServices daemon;
  const CommandRun run =
      RunCommand("priors export --out /nonexistent/p.json --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("/nonexistent/p.json"));
}

}  // namespace
}  // namespace sweepstake::cli
