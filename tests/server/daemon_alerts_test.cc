// Tests how the daemon connects alerts to the webhook, the file of silences and the metrics.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "server/alerts/alert_monitor.h"
#include "server/daemon.h"
#include "server/daemon_site.h"
#include "sweepstake/v1/alerts.grpc.pb.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"
#include "tests/server/alerts/webhook_receiver.h"
#include "tests/server/sessions/manual_clock.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class DaemonAlertsTest : public ::testing::Test {
 protected:
  DaemonAlertsTest() {
    config_.listen = "127.0.0.1:0";
    config_.http = "127.0.0.1:0";
    config_.http_hosts = "dash.example";
    config_.data = directory_.path() / "data";
    config_.log_level = "off";
    config_.webhook = receiver_.url();
  }
  void Start() {
    auto daemon = Daemon::Start(config_, clock_);
    ASSERT_TRUE(daemon.ok()) << daemon.status();
    daemon_ = *std::move(daemon);
    channel_ = grpc::CreateChannel("127.0.0.1:" + std::to_string(daemon_->port()),
                                   grpc::InsecureChannelCredentials());
  }
  // Begins a session in manual mode, which is a notice. It ends with `game_`.
  void Play() {
    context_ = std::make_unique<grpc::ClientContext>();
    game_ = v1::TelemetryService::NewStub(channel_)->StreamTelemetry(context_.get());
    v1::StreamTelemetryRequest request;
    v1::Hello& hello = *request.mutable_hello();
    hello.set_protocol_version(1);
    hello.set_project("game");
    hello.set_scene("harbour");
    hello.add_arms()->set_name("Grid");
    hello.mutable_arms(0)->set_backend_version(1);
    hello.set_mode(v1::MODE_MANUAL);
    game_->Write(request);
    v1::StreamTelemetryResponse welcome;
    ASSERT_TRUE(game_->Read(&welcome));
  }
  void Stop() {
    if (context_ != nullptr) context_->TryCancel();
    if (game_ != nullptr) game_->Finish();
    game_.reset();
    context_.reset();
    channel_.reset();
    daemon_.reset();
  }
  void TearDown() override { Stop(); }
  v1::ListAlertsResponse List() {
    grpc::ClientContext context;
    v1::ListAlertsResponse response;
    EXPECT_TRUE(v1::AlertsService::NewStub(channel_)->ListAlerts(&context, {}, &response).ok());
    return response;
  }
  // Lets looks pass until the condition is true.
  [[nodiscard]] bool AfterLooks(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      clock_.Advance(alerts::AlertMonitor::kLookIntervalNs);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  test_support::TemporaryDirectory directory_;
  alerts::WebhookReceiver receiver_;
  Config config_;
  sessions::ManualClock clock_;
  std::unique_ptr<Daemon> daemon_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse>>
      game_;
};

TEST_F(DaemonAlertsTest, TheWebhookReceivesTheAlertWithALink) {
  Start();
  Play();
  ASSERT_TRUE(AfterLooks([this] { return receiver_.request_count() == 1; }));
  const nlohmann::json message = nlohmann::json::parse(receiver_.Await(1)[0].body);
  EXPECT_EQ(message["status"], "begins");
  EXPECT_EQ(message["daemon_version"], SWEEPSTAKE_VERSION);
  ASSERT_EQ(message["alerts"].size(), 1u);
  EXPECT_EQ(message["alerts"][0]["rule"], "manual");
  EXPECT_EQ(message["alerts"][0]["url"], "https://dash.example/scenes/game/harbour?reward=3");
}

TEST_F(DaemonAlertsTest, AReloadSetsTheWebhookAndTheScenesWithMetrics) {
  config_.webhook = "";
  Start();
  Play();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  const auto page = [this] { return test_support::Get(daemon_->http_port(), "/metrics").body; };
  EXPECT_THAT(page(), HasSubstr("sweepstake_alerts{rule=\"manual\",silenced=\"false\"} 1"));
  EXPECT_EQ(page().find("sweepstake_scene_"), std::string::npos);

  Config changed = config_;
  changed.webhook = receiver_.url();
  changed.rpc.alerts.max_metric_scenes = 5;
  daemon_->Reload(changed);
  EXPECT_TRUE(AfterLooks([&] {
    return page().find("sweepstake_scene_sessions{project=\"game\",scene=\"harbour\"") !=
           std::string::npos;
  }));
  context_->TryCancel();
  ASSERT_TRUE(AfterLooks([this] { return receiver_.request_count() > 0; }));
  EXPECT_THAT(receiver_.Await(1)[0].body, HasSubstr("\"status\":\"ends\""));
}

TEST_F(DaemonAlertsTest, ASilenceSurvivesARestart) {
  Start();
  Play();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  v1::SilenceAlertRequest request;
  request.set_alert_id(List().alerts(0).id());
  request.set_comment("known");
  v1::SilenceAlertResponse response;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(
        v1::AlertsService::NewStub(channel_)->SilenceAlert(&context, request, &response).ok());
  }
  Stop();
  const fs::path file = config_.data / "silences.json";
  ASSERT_TRUE(fs::exists(file));
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  Start();
  Play();
  ASSERT_TRUE(AfterLooks([this] { return List().alert_count() == 1; }));
  EXPECT_EQ(List().alerts(0).silence().comment(), "known");
}

TEST(PageUrlTest, TheAddressOfThePageIsKnownFromTheSettings) {
  Config config;
  EXPECT_EQ(PageUrl(config), "");
  config.http = "127.0.0.1:7434";
  EXPECT_EQ(PageUrl(config), "http://127.0.0.1:7434");
  config.http_base = "/tools";
  config.http_hosts = " dash.example, other.example";
  EXPECT_EQ(PageUrl(config), "https://dash.example/tools");
  config.http_base = "";
  config.http = "0.0.0.0:7434";
  config.rpc.tls.cert = "cert.pem";
  config.rpc.tls.key = "key.pem";
  EXPECT_EQ(PageUrl(config), "https://dash.example:7434");
  config.http_hosts = "";
  EXPECT_EQ(PageUrl(config), "");
  config.http = "daemon.example:7434";
  EXPECT_EQ(PageUrl(config), "https://daemon.example:7434");
  config.http = "127.0.0.1:0";
  EXPECT_EQ(PageUrl(config), "");
}

}  // namespace
}  // namespace sweepstake::server
