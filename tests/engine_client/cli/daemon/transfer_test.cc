// Checks the requests and output of the commands against services with scripted answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
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

TEST(ListPosteriors, LetsTheDaemonSelectTheScene) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages = {PageWith({"b"}), PageWith({"b"})};
  const auto scenes = ListPosteriors({daemon.address()}, "", "b");
  ASSERT_TRUE(scenes.ok());
  EXPECT_EQ(scenes->size(), 2U);
  EXPECT_EQ(daemon.posteriors.listed_scene.get(), "b");
}

v1::WatchPosteriorsResponse DecisionOf(uint64_t id) {
  v1::WatchPosteriorsResponse event;
  v1::DecisionEvent& decision = *event.add_decisions();
  decision.set_scene("s");
  decision.set_decision_id(id);
  decision.set_active_arm("SAP");
  return event;
}

TEST(WatchPosteriors, PassesEachEventAndReconnectsUntilTheDaemonRefuses) {
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
  EXPECT_GE(return_count, 1) << "a second time if the connection is seen before the refusal";
  EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition);
  EXPECT_EQ(status.message(), "not any more");
  EXPECT_EQ(daemon.posteriors.watched_scene.get(), "s");
}

TEST(WatchPosteriors, EndsWithoutAnErrorWhenStopped) {
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

TEST(WatchCommand, PrintsEventsAsTheyArriveAndReportsALostDaemon) {
  FakeDaemonServices daemon;
  daemon.posteriors.watch_limit = 1;
  daemon.posteriors.events = {DecisionOf(7)};
  daemon.posteriors.events->emplace_back().mutable_posterior()->set_scene("arena");
  const CommandRun run = RunCommand("watch --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1) << "the last watch is refused";
  EXPECT_THAT(run.out, HasSubstr("s: decision 7, SAP"));
  EXPECT_THAT(run.out, HasSubstr(" / arena"));
  EXPECT_THAT(run.err, HasSubstr("ended the watch; trying again\n"));
}

TEST(WatchCommand, ReportsWhenTheDaemonIsConnectedAgain) {
  FakeDaemonServices daemon;
  daemon.posteriors.events = {DecisionOf(7)};
  const CommandRun run = RunCommand("watch --daemon " + daemon.address());
  EXPECT_THAT(run.err, HasSubstr("trying again\nsweepstake: connected again\n"));
}

TEST(WatchCommand, FollowWithJsonPrintsOneDocumentPerLine) {
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

TEST(WatchCommand, OnceWithoutPosteriorsSaysThatThereAreNone) {
  FakeDaemonServices daemon;
  daemon.posteriors.pages = {PageWith({})};
  const CommandRun run = RunCommand("watch --once --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "The daemon has no matching posteriors yet\n");
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
  session.set_machine_class("desktop");
  session.set_active_arm("Grid");
  session.set_initial_arm("SAP");
  session.set_takes_orders(true);
  session.set_mode(v1::MODE_AI);
  session.set_unix_start_ms(1'700'000'000'000);
  session.set_dropped_frame_count(17);
  return session;
}

TEST(AlertsCommand, ListsTheAlertsAndCountsTheRest) {
  FakeDaemonServices daemon;
  const std::string at = " --daemon " + daemon.address();
  EXPECT_EQ(RunCommand("alerts" + at).out, "Nothing needs a person\n");
  v1::ListAlertsResponse list;
  v1::Alert& alert = *list.add_alerts();
  alert.set_id("0123456789abcdef");
  alert.set_rule("ambiguous");
  alert.set_severity(v1::ALERT_SEVERITY_SERIOUS);
  alert.set_project("game");
  alert.set_scene("harbour");
  alert.set_machine_class("desktop");
  alert.set_reward_version(3);
  alert.set_text("No algorithm is clearly the best yet.");
  alert.set_session_count(2);
  alert.add_session_ids("5e55");
  alert.set_unix_since_ms(1'700'000'000'000);
  alert.set_loss_us(30.5);
  alert.mutable_silence()->set_silenced_by("alice");
  list.set_alert_count(4);
  list.set_serious_count(1);
  daemon.alerts.list = list;
  const CommandRun text = RunCommand("alerts --project game" + at);
  EXPECT_EQ(daemon.alerts.list_request->project(), "game");
  for (const char* part : {"serious", "game", "harbour", "desktop", "2023-11-14 22:13:20", "alice",
                           "No algorithm is clearly the best yet.", "3 more alerts"}) {
    EXPECT_THAT(text.out, HasSubstr(part));
  }
  const auto json = nlohmann::json::parse(RunCommand("alerts --json" + at).out);
  EXPECT_EQ(json["alert_count"], 4);
  EXPECT_EQ(json["serious_count"], 1);
  const nlohmann::json& first = json["alerts"][0];
  EXPECT_EQ(first["id"], "0123456789abcdef");
  EXPECT_EQ(first["session_ids"], nlohmann::json::array({"5e55"}));
  EXPECT_EQ(first["loss_us"], 30.5);
  EXPECT_EQ(first["reward_version"], 3);
  EXPECT_TRUE(first["silence"]["unix_until_ms"].is_null());
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
  EXPECT_EQ(json["sessions"][1]["machine_class"], "desktop");
  EXPECT_EQ(json["sessions"][1]["initial_arm"], "SAP");
  EXPECT_EQ(json["sessions"][1]["takes_orders"], true);
  EXPECT_EQ(json["sessions"][1]["shows_boxes"], false);
}

TEST(SessionsCommand, WatchesUntilTheDaemonRefusesIt) {
  FakeDaemonServices daemon;
  daemon.sessions.pages->resize(1);
  daemon.sessions.events->resize(2);
  *daemon.sessions.events->at(0).add_sessions() = Session("one");
  daemon.sessions.events->at(0).mutable_stamp()->set_boot(~0ull);
  daemon.sessions.events->at(0).mutable_stamp()->set_sequence(5);
  v1::SessionEnded ended;
  ended.set_session_id("one");
  ended.set_end(v1::SESSION_END_KICKED);
  *daemon.sessions.events->at(1).add_ended() = ended;
  const CommandRun text = RunCommand("sessions watch --daemon " + daemon.address());
  EXPECT_EQ(text.exit_code, 1) << "the last watch is refused";
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

TEST(SessionsCommand, KicksASessionOrReportsTheError) {
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
            "The daemon has no matching decision log\n");
}

TEST(ExportAudit, WritesTheRowsOfAllParts) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(2);
  const decision::AuditRow one = decision::MissingRow("id", 1, 1);
  const decision::AuditRow two = decision::MissingRow("id", 2, 7);
  *daemon.audit.parts->at(0).add_rows() = ToProto(one);
  *daemon.audit.parts->at(1).add_rows() = ToProto(two);
  const TemporaryDirectory folder;
  const auto count =
      ExportAudit({daemon.address()}, {.session_id = "id", .project = "p", .scene = "s"},
                  folder.path() / "log.csv");
  ASSERT_TRUE(count.ok()) << count.status().message();
  EXPECT_EQ(*count, 2U);
  std::ostringstream text;
  text << std::ifstream(folder.path() / "log.csv").rdbuf();
  EXPECT_EQ(text.str(), decision::AuditHeader() + "\n" + decision::AuditLines(one) + "\n" +
                            decision::AuditLines(two) + "\n");
  EXPECT_EQ(daemon.audit.export_request.get().filter().session_id(), "id");
}

TEST(ExportAudit, LeavesNoFileWhenTheDaemonFails) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(1);
  daemon.audit.export_status = grpc::Status(grpc::StatusCode::NOT_FOUND, "no session id");
  const TemporaryDirectory folder;
  const auto count = ExportAudit({daemon.address()}, {}, folder.path() / "log.csv");
  EXPECT_EQ(count.status().code(), StatusCode::kNotFound);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ExportAudit, WithoutRowsGivesExitCodeOneAndKeepsTheFile) {
  FakeDaemonServices daemon;
  daemon.audit.parts->resize(1);
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "log.csv").string();
  std::ofstream(file) << "good";
  const CommandRun run =
      RunCommand("audit export --session nosuch --out " + file + " --daemon " + daemon.address());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("the daemon has no matching decisions"));
  EXPECT_EQ(FileText(file), "good");
}

TEST(SessionsCommand, SteersAGame) {
  FakeDaemonServices daemon;
  const auto run = [&](const std::string& words) {
    const CommandRun done = RunCommand("sessions " + words + " --daemon " + daemon.address());
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return done.out;
  };
  EXPECT_EQ(run("pin one KDTree"), "one follows the order: manual, KDTree is active\n");
  EXPECT_EQ(daemon.sessions.order_request->session_id(), "one");
  EXPECT_EQ(daemon.sessions.order_request->mode(), v1::MODE_MANUAL);
  EXPECT_EQ(run("pin one"), "one follows the order: manual, SAP is active\n");
  EXPECT_EQ(daemon.sessions.order_request->mode(), v1::MODE_MANUAL);
  EXPECT_EQ(daemon.sessions.order_request->arm(), "");
  EXPECT_EQ(run("release one"), "one follows the order: ai, SAP is active\n");
  EXPECT_EQ(nlohmann::json::parse(run("release one --json"))["mode"], "ai");
}

}  // namespace
}  // namespace sweepstake::cli
