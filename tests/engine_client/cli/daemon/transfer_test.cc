// What the commands ask a daemon for, against services with scripted answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine_client/cli/daemon/audit_transfer.h"
#include "engine_client/cli/daemon/posteriors_transfer.h"
#include "engine_client/cli/daemon/priors_transfer.h"
#include "engine_client/cli/daemon/sessions_transfer.h"
#include "tests/engine_client/cli/command_run.h"
#include "tests/engine_client/cli/daemon/fake_daemon_services.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using test_support::FakeDaemonServices;
using test_support::FileText;
using test_support::TemporaryDirectory;
using testing::ElementsAre;
using testing::HasSubstr;

v1::ListPosteriorsResponse PageWith(const std::vector<std::string>& scenes) {
  v1::ListPosteriorsResponse page;
  for (const std::string& name : scenes) {
    v1::ScenePosterior& scene = *page.add_scenes();
    scene.set_project("p");
    scene.set_scene(name);
  }
  return page;
}

TEST(ListPosteriors, ReadsEveryPage) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages = {PageWith({"a", "b"}), PageWith({}), PageWith({"c"})};
  const auto scenes = ListPosteriors({daemon.address()}, "p", "");
  ASSERT_TRUE(scenes.ok()) << scenes.status().message();
  ASSERT_EQ(scenes->size(), 3U);
  EXPECT_EQ((*scenes)[2].scene(), "c");
  EXPECT_THAT(daemon.posteriors.projects.get(), ElementsAre("p", "p", "p"));
}

TEST(ListPosteriors, KeepsOnlyTheSceneThatIsAskedFor) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages = {PageWith({"a", "b"}), PageWith({"b"})};
  const auto scenes = ListPosteriors({daemon.address()}, "", "b");
  ASSERT_TRUE(scenes.ok());
  EXPECT_EQ(scenes->size(), 2U);
  EXPECT_TRUE(ListPosteriors({daemon.address()}, "", "z")->empty());
}

v1::WatchPosteriorsResponse DecisionOf(uint64_t id) {
  v1::WatchPosteriorsResponse event;
  v1::DecisionEvent& decision = *event.add_decisions();
  decision.set_scene("s");
  decision.set_decision_id(id);
  decision.set_active_arm("SAP");
  return event;
}

TEST(WatchPosteriors, HandsOnEachEventAndGoesOnWhereTheDaemonIsLostUntilItRefuses) {
  FakeDaemonServices daemon;
  daemon.posteriors.events = {DecisionOf(1), DecisionOf(2), DecisionOf(3)};
  std::vector<uint64_t> seen;
  int loss_count = 0;
  std::atomic<int> return_count = 0;
  const Status status = WatchPosteriors(
      {daemon.address()}, "p", "s", [] { return false; },
      [&](const v1::WatchPosteriorsResponse& event) {
        seen.push_back(event.decisions(0).decision_id());
      },
      [&](const Status& loss) {
        if (loss.ok()) {
          ++return_count;
          return;
        }
        EXPECT_EQ(loss.code(), StatusCode::kUnavailable);
        EXPECT_THAT(loss.message(), HasSubstr("ended the watch"));
        ++loss_count;
      });
  EXPECT_THAT(seen, ElementsAre(1, 2, 3, 1, 2, 3));
  EXPECT_EQ(loss_count, 2);
  EXPECT_GE(return_count, 1) << "and once more if it is seen before the refusal";
  EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition);
  EXPECT_EQ(status.message(), "not any more");
  EXPECT_EQ(daemon.posteriors.watched_scene.get(), "s");
}

TEST(WatchPosteriors, EndsWithoutAnErrorWhenItIsStopped) {
  FakeDaemonServices daemon;
  daemon.posteriors.events = {DecisionOf(1)};
  daemon.posteriors.ends_the_watch = false;
  std::atomic<bool> stopped = false;
  const Status status = WatchPosteriors(
      {daemon.address()}, "", "", [&] { return stopped.load(); },
      [&](const v1::WatchPosteriorsResponse&) { stopped = true; },
      [](const Status& connection) { ADD_FAILURE() << connection.message(); });
  EXPECT_TRUE(status.ok()) << status.message();
}

TEST(WatchCommand, PrintsEventsAsTheyComeAndSaysWhenTheDaemonIsLost) {
  FakeDaemonServices daemon;
  daemon.posteriors.watch_limit = 1;
  daemon.posteriors.events = {DecisionOf(7)};
  daemon.posteriors.events->emplace_back().mutable_posterior()->set_scene("arena");
  const CommandRun run = RunCommand("watch --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1) << "it is refused at last";
  EXPECT_THAT(run.out, HasSubstr("s: decision 7, SAP"));
  EXPECT_THAT(run.out, HasSubstr(" / arena"));
  EXPECT_THAT(run.err, HasSubstr("ended the watch; trying again\n"));
}

TEST(WatchCommand, SaysWhenTheDaemonIsBack) {
  FakeDaemonServices daemon;
  daemon.posteriors.events = {DecisionOf(7)};
  const CommandRun run = RunCommand("watch --daemon " + daemon.address());
  EXPECT_THAT(run.err, HasSubstr("trying again\nsweepstake: connected again\n"));
}

TEST(WatchCommand, FollowsInJsonWithADocumentPerLine) {
  FakeDaemonServices daemon;
  daemon.posteriors.watch_limit = 1;
  daemon.posteriors.events = {DecisionOf(7)};
  daemon.posteriors.events->front().add_decisions()->set_decision_id(8);
  daemon.posteriors.events->emplace_back().mutable_posterior()->set_scene("arena");
  const CommandRun run = RunCommand("watch --json --follow --daemon " + daemon.address());
  std::istringstream lines(run.out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["decision"]["decision_id"], 7);
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["decision"]["decision_id"], 8);
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["posterior"]["scene"], "arena");
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(WatchCommand, SaysOnceThatThereIsNothingYet) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages = {PageWith({})};
  const CommandRun run = RunCommand("watch --once --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "The daemon has no posteriors of this yet\n");
}

PriorRecord SomeRecord(uint64_t sequence) {
  return {.project = "p",
          .scene = "s",
          .measured_by = "lane",
          .arm = "SAP",
          .backend_version = 3,
          .machine_class = "m",
          .reward_version = 2,
          .source_id = "session-" + std::to_string(sequence),
          .source_sequence = sequence,
          .alpha_increment = 1.5,
          .beta_increment = 2.25,
          .window_count = 4,
          .bail_out_count = 1,
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

TEST(ImportPriors, ReturnsTheReasonOfARefusal) {
  FakeDaemonServices daemon;
  daemon.priors.import_status =
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "record 0 has no arm");
  const auto result = ImportPriors({daemon.address()}, std::vector{SomeRecord(1)});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(result.status().message(), "record 0 has no arm");
}

TEST(ExportPriors, KeepsEveryFieldOnTheWayThereAndBack) {
  FakeDaemonServices daemon;
  const PriorRecord record = SomeRecord(9);
  ASSERT_TRUE(ImportPriors({daemon.address()}, std::vector{record}).ok());
  daemon.priors.parts->resize(2);
  *daemon.priors.parts->at(1).add_records() = daemon.priors.imported->at(0);
  const auto exported = ExportPriors({daemon.address()}, "p", "s");
  ASSERT_TRUE(exported.ok()) << exported.status().message();
  ASSERT_EQ(exported->records.size(), 1U);
  EXPECT_EQ(FormatPriors(exported->records), FormatPriors(std::vector{record}));
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
            file + ": 1 of 2 records were new or newer, 1 were known already\n");
  EXPECT_EQ(daemon.priors.imported->size(), 2U);
}

TEST(PriorsCommand, SaysWhichRecordsAreKnownUnderAnotherScene) {
  FakeDaemonServices daemon;
  PriorRecord renamed = SomeRecord(2);
  renamed.scene = "renamed";
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
  ASSERT_TRUE(WritePriorsFile(std::vector{renamed}, file).ok());
  const CommandRun run = RunCommand("priors import --in " + file + " --daemon " + daemon.address());
  EXPECT_THAT(run.out, HasSubstr("1 of these are not there under their project and scene"));
}

TEST(ImportPriors, CountsNothingAsAbsentWhereTheDaemonLeavesFoldedRecordsOut) {
  FakeDaemonServices daemon;
  daemon.priors.parts->resize(1);
  const std::vector<PriorRecord> records = {SomeRecord(1), SomeRecord(2)};
  EXPECT_EQ(ImportPriors({daemon.address()}, records)->absent_count, 2U);
  daemon.priors.parts->at(0).set_folded_record_count(1);
  EXPECT_EQ(ImportPriors({daemon.address()}, records)->absent_count, 0U);
}

TEST(PriorsCommand, AnExportOfNothingEndsWithOneAndLeavesTheFile) {
  FakeDaemonServices daemon;
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  std::ofstream(file) << "good";
  const CommandRun run =
      RunCommand("priors export --scene nosuch --out " + file + " --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("the daemon has no such records"));
  EXPECT_EQ(FileText(file), "good");
}

TEST(PriorsCommand, AnExportSaysWhatTheDaemonLeftOut) {
  FakeDaemonServices daemon;
  daemon.priors.parts->resize(2);
  for (const size_t i : {0U, 1U}) {
    daemon.priors.parts->at(i).set_folded_record_count(7);
    daemon.priors.parts->at(i).set_folded_window_count(30);
  }
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "p.json").string();
  const std::string command = "priors export --out " + file + " --daemon " + daemon.address();
  EXPECT_EQ(RunCommand(command).out,
            file +
                ": 0 records\n14 more of old sessions, with 60 windows, were left out: the daemon "
                "has folded them together (fold_days)\n");
  EXPECT_THAT(RunCommand(command + " --json").out,
              AllOf(HasSubstr("\"folded_records\": 14"), HasSubstr("\"folded_windows\": 60")));
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
  EXPECT_EQ(RunCommand(command).out,
            "2 sources with 9 records of 70 windows and visits would be revoked; say --yes to do "
            "it\n");
  const v1::RevokePriorsRequest asked = daemon.priors.revoke_request.get();
  EXPECT_TRUE(asked.preview());
  EXPECT_EQ(asked.project(), "p");
  EXPECT_EQ(asked.source_id(), "s");
  EXPECT_EQ(asked.build(), "1.3");
  EXPECT_EQ(asked.token_id(), 7);
  EXPECT_EQ(asked.unix_from_s(), 10);
  EXPECT_EQ(asked.unix_until_s(), 20);
  const auto done = nlohmann::json::parse(RunCommand(command + " --yes --json").out);
  EXPECT_FALSE(daemon.priors.revoke_request->preview());
  EXPECT_EQ(done["revoked"], true);
  EXPECT_EQ(done["sources"], 2);
  EXPECT_EQ(done["records"], 9);
  EXPECT_EQ(done["windows"], 70);
}

TEST(PriorsCommand, AnExportThatCannotBeWrittenEndsWithTwo) {
  FakeDaemonServices daemon;
  const CommandRun run =
      RunCommand("priors export --out /nonexistent/p.json --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("/nonexistent/p.json"));
}

v1::ListAuditSegmentsResponse SegmentsOf(const std::string& session, uint64_t row_count) {
  v1::ListAuditSegmentsResponse part;
  v1::AuditSegment& segment = *part.add_segments();
  segment.set_session_id(session);
  segment.set_segment(2);
  segment.set_project("p");
  segment.set_scene("s");
  segment.set_unix_start_ms(1'700'000'000'000);
  segment.set_row_count(row_count);
  segment.set_first_row(31);
  segment.set_lost_row_count(17);
  return part;
}

TEST(AuditCommand, ListsTheSegmentsOfAllParts) {
  FakeDaemonServices daemon;
  daemon.audit.segments = {SegmentsOf("one", 5), SegmentsOf("two", 7)};
  const auto rows = ListAudit({daemon.address()}, {});
  ASSERT_TRUE(rows.ok());
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ((*rows)[1].session_id(), "two");
  EXPECT_EQ((*rows)[1].row_count(), 7U);
  const CommandRun run = RunCommand("audit list --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("one"));
  EXPECT_THAT(run.out, HasSubstr("2023-11-14 22:13:20")) << "UTC";
  EXPECT_THAT(run.out, HasSubstr("first row"));
  EXPECT_THAT(run.out, HasSubstr("31"));
  EXPECT_THAT(run.out, HasSubstr("lost rows"));
  EXPECT_THAT(run.out, HasSubstr("17"));
}

v1::SessionInfo Session(const std::string& id) {
  v1::SessionInfo session;
  session.set_session_id(id);
  session.set_project("p");
  session.set_scene("s");
  session.set_build("1.2.3");
  session.set_client_address("ipv4:10.0.0.1:5000");
  session.set_state(v1::SESSION_STATE_CONNECTED);
  session.set_active_arm("Grid");
  session.set_mode(v1::MODE_AI);
  session.set_unix_start_ms(1'700'000'000'000);
  session.set_dropped_frame_count(17);
  return session;
}

TEST(SessionsCommand, ListsTheSessionsOfAllPages) {
  FakeDaemonServices daemon;
  daemon.sessions.pages->resize(2);
  *daemon.sessions.pages->at(0).add_sessions() = Session("one");
  *daemon.sessions.pages->at(1).add_sessions() = Session("two");
  const CommandRun text = RunCommand("sessions list --daemon " + daemon.address());
  EXPECT_EQ(text.exit_code, 0);
  for (const char* part : {"one", "two", "1.2.3", "ipv4:10.0.0.1:5000", "connected", "Grid", "ai",
                           "2023-11-14 22:13:20", "17"}) {
    EXPECT_THAT(text.out, HasSubstr(part));
  }
  const auto json =
      nlohmann::json::parse(RunCommand("sessions list --json --daemon " + daemon.address()).out);
  ASSERT_EQ(json["sessions"].size(), 2U);
  EXPECT_EQ(json["sessions"][1]["session_id"], "two");
  EXPECT_EQ(json["sessions"][1]["state"], "connected");
  EXPECT_TRUE(json["sessions"][1]["unix_last_message_ms"].is_null());
}

TEST(SessionsCommand, WatchesUntilTheDaemonRefusesIt) {
  FakeDaemonServices daemon;
  daemon.sessions.pages->resize(1);
  daemon.sessions.events->resize(2);
  *daemon.sessions.events->at(0).add_sessions() = Session("one");
  daemon.sessions.events->at(0).mutable_stamp()->set_boot(~0ull);
  daemon.sessions.events->at(0).mutable_stamp()->set_sequence(5);
  v1::SessionEnded& ended = *daemon.sessions.events->at(1).add_ended();
  ended.set_session_id("one");
  ended.set_end(v1::SESSION_END_KICKED);
  const CommandRun text = RunCommand("sessions watch --daemon " + daemon.address());
  EXPECT_EQ(text.exit_code, 1) << "it is refused at last";
  EXPECT_THAT(text.err, HasSubstr("ended the watch; trying again\n"));
  EXPECT_THAT(text.out, HasSubstr("The daemon has no sessions\n"));
  EXPECT_THAT(text.out, HasSubstr("one of p/s: connected, Grid, ai\n"));
  EXPECT_THAT(text.out, HasSubstr("one ended: kicked\n"));
  daemon.sessions.watch_count = 0;
  std::istringstream lines(RunCommand("sessions watch --json --daemon " + daemon.address()).out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["event"], "18446744073709551615:5");
  EXPECT_EQ(nlohmann::json::parse(line)["session"]["session_id"], "one");
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["ended"]["end"], "kicked");
}

TEST(SessionsCommand, KicksAndSaysWhyNot) {
  FakeDaemonServices daemon;
  CommandRun run = RunCommand("sessions kick one --may-return --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "one is disconnected and may return\n");
  EXPECT_EQ(daemon.sessions.kick_request.get().session_id(), "one");
  EXPECT_TRUE(daemon.sessions.kick_request.get().may_return());
  EXPECT_EQ(RunCommand("sessions kick one --daemon " + daemon.address()).out,
            "one is being ended\n");
  daemon.sessions.kick_status =
      grpc::Status(grpc::StatusCode::NOT_FOUND, "there is no such session");
  EXPECT_EQ(KickSession({daemon.address()}, "two", false).code(), StatusCode::kNotFound);
  run = RunCommand("sessions kick two --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("there is no such session"));
}

TEST(AuditCommand, SaysWhenThereIsNoLog) {
  FakeDaemonServices daemon;
  EXPECT_EQ(RunCommand("audit list --daemon " + daemon.address()).out,
            "The daemon has no log of this\n");
}

TEST(ExportAudit, WritesTheDaemonsHeaderAndRows) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(2);
  daemon.audit.parts->at(0).set_header("a,b");
  daemon.audit.parts->at(0).add_rows("1,2");
  daemon.audit.parts->at(1).add_rows("3,4");
  const TemporaryDirectory folder;
  const auto count =
      ExportAudit({daemon.address()}, {.session_id = "id", .project = "p", .scene = "s"},
                  folder.path() / "log.csv");
  ASSERT_TRUE(count.ok()) << count.status().message();
  EXPECT_EQ(*count, 2U);
  std::ostringstream text;
  text << std::ifstream(folder.path() / "log.csv").rdbuf();
  EXPECT_EQ(text.str(), "a,b\n1,2\n3,4\n");
  EXPECT_EQ(daemon.audit.export_request.get().session_id(), "id");
}

TEST(ExportAudit, LeavesNoFileWhenTheDaemonFails) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(1);
  daemon.audit.parts->at(0).set_header("a,b");
  daemon.audit.export_status = grpc::Status(grpc::StatusCode::NOT_FOUND, "no session id");
  const TemporaryDirectory folder;
  const auto count = ExportAudit({daemon.address()}, {}, folder.path() / "log.csv");
  EXPECT_EQ(count.status().code(), StatusCode::kNotFound);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ExportAudit, OfNothingLeavesTheFileAndEndsWithOne) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(1);
  daemon.audit.parts->at(0).set_header("a,b");
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "log.csv").string();
  std::ofstream(file) << "good";
  const CommandRun run =
      RunCommand("audit export --session nosuch --out " + file + " --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("the daemon has no such decisions"));
  EXPECT_EQ(FileText(file), "good");
}

TEST(SessionsCommand, SteersAGame) {
  FakeDaemonServices daemon;
  const auto run = [&](const std::string& words) {
    const CommandRun done = RunCommand("sessions " + words + " --daemon " + daemon.address());
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return done.out;
  };
  EXPECT_EQ(run("pin one KDTree"), "one obeys: manual, KDTree is active\n");
  EXPECT_EQ(daemon.sessions.order_request->session_id(), "one");
  EXPECT_EQ(daemon.sessions.order_request->mode(), v1::MODE_MANUAL);
  EXPECT_EQ(run("pin one"), "one obeys: manual, SAP is active\n");
  EXPECT_EQ(daemon.sessions.order_request->mode(), v1::MODE_MANUAL);
  EXPECT_EQ(daemon.sessions.order_request->arm(), "");
  EXPECT_EQ(run("release one"), "one obeys: ai, SAP is active\n");
  EXPECT_EQ(nlohmann::json::parse(run("release one --json"))["mode"], "ai");
}

}  // namespace
}  // namespace sweepstake::cli
