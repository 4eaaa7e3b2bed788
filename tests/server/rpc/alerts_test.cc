// Tests AlertsService against a real server: the alerts of its sessions, silences and their rights.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <mutex>

#include "server/alerts/alert_monitor.h"
#include "sweepstake/v1/alerts.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class AlertsTest : public RpcTest {
 protected:
  AlertsTest() {
    options_.alerts.announce = [this](const alerts::AlertChanges& changes) {
      const std::lock_guard lock(mutex_);
      for (const alerts::Alert& alert : changes.begun) begun_.push_back(alert);
      for (const alerts::Alert& alert : changes.ended) ended_.push_back(alert);
    };
    options_.alerts.save_silences = [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      silences_ = text;
    };
    options_.alerts.checks = [this] {
      const std::lock_guard lock(mutex_);
      return checks_;
    };
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("operator", auth::Role::kOperator, {"game"});
    tokens_.Add("watcher", auth::Role::kWatch, {"game"});
    tokens_.Add("other", auth::Role::kOperator, {"other"});
  }

  template <typename Request, typename Response>
  grpc::Status Call(grpc::Status (v1::AlertsService::Stub::*method)(grpc::ClientContext*,
                                                                    const Request&, Response*),
                    const Request& request, Response& response, const std::string& token) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token + "-token");
    v1::AlertsService::Stub stub(channel_);
    return (stub.*method)(&context, request, &response);
  }
  v1::ListAlertsResponse List(const std::string& token = "all",
                              const v1::ListAlertsRequest& request = {}) {
    v1::ListAlertsResponse response;
    EXPECT_TRUE(Call(&v1::AlertsService::Stub::ListAlerts, request, response, token).ok());
    return response;
  }
  std::vector<std::string> Rules(const std::string& token = "all") {
    std::vector<std::string> rules;
    const v1::ListAlertsResponse list = List(token);
    for (const v1::Alert& alert : list.alerts()) rules.push_back(alert.rule());
    return rules;
  }
  grpc::Status Silence(const std::string& id, const std::string& token = "all",
                       uint64_t duration_ms = 0, const std::string& comment = "") {
    v1::SilenceAlertRequest request;
    request.set_alert_id(id);
    request.set_duration_ms(duration_ms);
    request.set_comment(comment);
    v1::SilenceAlertResponse response;
    return Call(&v1::AlertsService::Stub::SilenceAlert, request, response, token);
  }
  grpc::Status Unsilence(const std::string& id, const std::string& token = "all") {
    v1::UnsilenceAlertRequest request;
    request.set_alert_id(id);
    v1::UnsilenceAlertResponse response;
    return Call(&v1::AlertsService::Stub::UnsilenceAlert, request, response, token);
  }
  // Lets looks pass until the condition is true.
  [[nodiscard]] bool AfterLooks(const std::function<bool()>& condition) {
    return Eventually([&] {
      if (condition()) return true;
      clock_.Advance(alerts::AlertMonitor::kLookIntervalNs);
      return false;
    });
  }
  void SetChecks(std::vector<alerts::CheckResult> checks) {
    const std::lock_guard lock(mutex_);
    checks_ = std::move(checks);
  }
  std::vector<std::string> EndedRules() {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> rules;
    for (const alerts::Alert& alert : ended_) rules.emplace_back(NameOf(alert.key.rule));
    return rules;
  }
  std::string silences() {
    const std::lock_guard lock(mutex_);
    return silences_;
  }
  // Begins a session in manual mode, which is a notice.
  std::unique_ptr<TelemetryClient> ManualGame(const std::string& project = "game") {
    return ManualGame(project, channel_);
  }
  std::unique_ptr<TelemetryClient> ManualGame(const std::string& project,
                                              const std::shared_ptr<grpc::Channel>& channel) {
    v1::Hello hello = HelloMessage();
    hello.set_project(project);
    hello.set_mode(v1::MODE_MANUAL);
    auto client = std::make_unique<TelemetryClient>(channel, "all-token");
    session_id_ = client->Open(hello).session_id();
    return client;
  }

  ScriptedTokens tokens_;
  std::mutex mutex_;
  std::vector<alerts::CheckResult> checks_;  // guarded by mutex_
  std::vector<alerts::Alert> begun_;         // guarded by mutex_
  std::vector<alerts::Alert> ended_;         // guarded by mutex_
  std::string silences_;                     // guarded by mutex_
  std::string session_id_;
};

TEST_F(AlertsTest, ASessionInManualModeIsANotice) {
  const auto game = ManualGame();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  const v1::ListAlertsResponse list = List();
  const v1::Alert& alert = list.alerts(0);
  EXPECT_EQ(alert.rule(), "manual");
  EXPECT_EQ(alert.severity(), v1::ALERT_SEVERITY_NOTICE);
  EXPECT_EQ(alert.project(), "game");
  EXPECT_EQ(alert.scene(), "harbour");
  EXPECT_EQ(alert.text(), "1 session is in manual mode and adds no evidence.");
  EXPECT_THAT(alert.session_ids(), ElementsAre(session_id_));
  EXPECT_FALSE(alert.has_silence());
  EXPECT_EQ(list.serious_count(), 0u);
}

TEST_F(AlertsTest, AnAlertThatHasEndedIsAnnounced) {
  {
    const auto game = ManualGame();
    ASSERT_TRUE(AfterLooks([this] { return Rules() == std::vector<std::string>{"manual"}; }));
    game->Send(Goodbye());
    game->Finish();
  }
  EXPECT_TRUE(AfterLooks([this] { return EndedRules() == std::vector<std::string>{"manual"}; }));
}

TEST_F(AlertsTest, ABailOutIsSeriousForTenMinutesEvenIfTheSessionEnds) {
  {
    TelemetryClient game(channel_, "all-token");
    v1::Hello hello = HelloMessage();
    game.Open(hello);
    game.Send(Frames(1, 30));
    game.Send(BailOut(2, 30));
    ASSERT_TRUE(AfterLooks([this] { return List().serious_count() == 1; }));
    EXPECT_THAT(Rules(), ElementsAre("bail_outs"));
    game.Send(Goodbye());
    game.Finish();
  }
  clock_.Advance(alerts::AlertMonitor::kLookIntervalNs);
  EXPECT_THAT(Rules(), ElementsAre("bail_outs"));
  EXPECT_TRUE(AfterLooks([this] { return Rules().empty(); }));
}

TEST_F(AlertsTest, ALostSessionIsANoticeAfterHalfAMinute) {
  {
    TelemetryClient game(channel_, "all-token");
    game.Open(HelloMessage());
  }
  EXPECT_TRUE(AfterLooks([this] { return Rules() == std::vector<std::string>{"lost_sessions"}; }));
}

TEST_F(AlertsTest, AFailedCheckConcernsTheWholeDaemon) {
  SetChecks({{.name = "store", .problem = "the disk is full", .remark = {}}});
  ASSERT_TRUE(AfterLooks([this] { return List("watcher").serious_count() == 1; }));
  const v1::ListAlertsResponse list = List("watcher");
  EXPECT_EQ(list.alerts(0).project(), "");
  EXPECT_EQ(list.alerts(0).reward_version(), 0u);
  EXPECT_EQ(list.alerts(0).text(), "Health check store: the disk is full.");
  // A token for some projects may see it, but not silence it for everybody.
  const std::string id = list.alerts(0).id();
  EXPECT_EQ(Silence(id, "operator").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(Silence(id, "all").ok());
}

TEST_F(AlertsTest, ATokenSeesTheAlertsOfItsProjectsOnly) {
  const auto game = ManualGame("game");
  const auto other = ManualGame("other");
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 2; }));
  const v1::ListAlertsResponse list = List("operator");
  ASSERT_EQ(list.alert_count(), 1u);
  EXPECT_EQ(list.alerts(0).project(), "game");
  const std::string id = list.alerts(0).id();
  EXPECT_EQ(Silence(id, "other").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Silence(id, "watcher").error_code(), grpc::StatusCode::PERMISSION_DENIED);
  v1::ListAlertsRequest request;
  request.set_project("other");
  EXPECT_EQ(List("all", request).alert_count(), 1u);
  v1::ListAlertsResponse refused;
  EXPECT_EQ(Call(&v1::AlertsService::Stub::ListAlerts, request, refused, "operator").error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(AlertsTest, TheListIsLimitedAndItsCountsAreNot) {
  const auto game = ManualGame("game");
  const auto other = ManualGame("other");
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 2; }));
  v1::ListAlertsRequest request;
  request.set_limit(1);
  const v1::ListAlertsResponse list = List("all", request);
  EXPECT_EQ(list.alerts_size(), 1);
  EXPECT_EQ(list.alert_count(), 2u);
}

TEST_F(AlertsTest, ASilenceIsShownRecordedAndEnded) {
  SetChecks({{.name = "store", .problem = "the disk is full", .remark = {}}});
  const auto game = ManualGame();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 2; }));
  const std::string check_id = List().alerts(0).id();
  const std::string manual_id = List().alerts(1).id();
  EXPECT_TRUE(Silence(check_id, "all", 3'600'000, "the new disk is coming").ok());
  v1::ListAlertsResponse list = List();
  EXPECT_EQ(list.serious_count(), 0u);
  EXPECT_EQ(list.alerts(0).id(), manual_id);
  EXPECT_EQ(list.alerts(1).silence().comment(), "the new disk is coming");
  EXPECT_GT(list.alerts(1).silence().unix_until_ms(), list.alerts(1).unix_since_ms());
  EXPECT_THAT(list.alerts(1).silence().silenced_by(), HasSubstr("all"));

  EXPECT_TRUE(Silence(manual_id, "operator").ok());
  EXPECT_TRUE(Unsilence(manual_id, "operator").ok());
  EXPECT_EQ(Unsilence(manual_id, "operator").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(Eventually([this] { return AdminRows().size() == 3; }));
  EXPECT_THAT(
      AdminRows(),
      ElementsAre(HasSubstr("silenced the alert check of the check store for 3600 s: the new disk"),
                  HasSubstr("silenced the alert manual of game/harbour until it ends"),
                  HasSubstr("ended the silence of the alert manual of game/harbour")));
}

TEST_F(AlertsTest, AnImpossibleSilenceIsRefused) {
  const auto game = ManualGame();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  const std::string id = List().alerts(0).id();
  EXPECT_EQ(Silence("0123456789abcdef").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Silence(id, "all", 1, "two\nlines").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Silence(id, "all", 1, std::string(201, 'x')).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Silence(id, "all", UINT64_MAX).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(silences(), IsEmpty());
}

TEST_F(AlertsTest, ASilenceSurvivesARestart) {
  SetChecks({{.name = "store", .problem = "the disk is full", .remark = {}}});
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  ASSERT_TRUE(Silence(List().alerts(0).id()).ok());
  options_.alerts.silences = silences();
  RestartServer();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  EXPECT_EQ(List().serious_count(), 0u);
  EXPECT_THAT(List().alerts(0).silence().silenced_by(), HasSubstr("all"));
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(begun_.size(), 1u);  // that of the first run
}

TEST_F(AlertsTest, DamagedSilencesAreReportedAndDoNotStopTheAlerts) {
  options_.alerts.silences = "{";
  RestartServer();
  EXPECT_TRUE(Eventually([this] {
    return logged_->text().find("the silences of alerts cannot be read") != std::string::npos;
  }));
  const auto game = ManualGame();
  EXPECT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
}

TEST_F(AlertsTest, TheFiguresOfTheMostPlayedScenesAreCollected) {
  EXPECT_TRUE(AfterLooks([this] { return server_->alert_figures()->scenes.empty(); }));
  options_.alerts.max_metric_scenes = 1;
  server_->Adjust(options_);
  v1::Hello hello = HelloMessage();
  hello.set_scene("quay");
  hello.set_machine_class("desktop");
  TelemetryClient first(channel_, "all-token");
  first.Open(hello);
  TelemetryClient second(channel_, "all-token");
  second.Open(hello);
  const auto game = ManualGame();
  ASSERT_TRUE(AfterLooks([this] { return server_->alert_figures()->scenes.size() == 1; }));
  ASSERT_TRUE(
      AfterLooks([this] { return server_->alert_figures()->scenes.at(0).session_count == 2; }));
  const alerts::SceneFigures scene = server_->alert_figures()->scenes.at(0);
  EXPECT_EQ(scene.project, "game");
  EXPECT_EQ(scene.scene, "quay");
  EXPECT_EQ(scene.machine_class, "desktop");
  EXPECT_EQ(scene.active_arm, "Grid");
  EXPECT_EQ(scene.expected_loss_us, std::nullopt);
  options_.alerts.max_metric_scenes = 0;
  server_->Adjust(options_);
  EXPECT_TRUE(AfterLooks([this] { return server_->alert_figures()->scenes.empty(); }));
}

TEST_F(AlertsTest, ALookReadsTablesOfManyTasks) {
  std::vector<std::unique_ptr<TelemetryClient>> games;
  const size_t count = alerts::AlertMonitor::kSessionsPerTask + 1;
  const auto other = SmallWindowChannel();  // because a connection may have 100 streams only
  for (size_t i = 0; i < count; ++i)
    games.push_back(ManualGame("game", i % 2 == 0 ? channel_ : other));
  EXPECT_TRUE(AfterLooks([&] {
    const auto list = List();
    return list.alert_count() == 1 && list.alerts(0).session_count() == count;
  }));
}

}  // namespace
}  // namespace sweepstake::rpc
