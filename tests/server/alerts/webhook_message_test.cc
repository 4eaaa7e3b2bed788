// Tests the JSON messages of the webhook.
#include "server/alerts/webhook_message.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sweepstake::alerts {
namespace {

const WebhookContext kContext = {.daemon_version = "1.2.3", .page_url = "https://dash.example"};

Alert SceneAlert(const std::string& scene = "harbour") {
  return {.id = "0123456789abcdef",
          .key = {.rule = Rule::kAmbiguous, .check = {}, .scene = {"game", scene, "desktop", 3}},
          .finding = {.severity = Severity::kSerious,
                      .text = "No algorithm is clearly the best yet.",
                      .session_count = 2,
                      .session_ids = {"5e55", "5e56"},
                      .loss_us = 30.5},
          .unix_since_ms = 1'700'000'000'000};
}

nlohmann::json MessageOf(const std::vector<Alert>& alerts,
                         const WebhookContext& context = kContext) {
  return nlohmann::json::parse(WebhookMessage("begins", alerts, 1'700'000'060'000, context));
}

// deploy/OPERATING.md shows this message.
TEST(WebhookMessageTest, TheFormIsDocumentedAndStable) {
  EXPECT_EQ(MessageOf({SceneAlert()}), nlohmann::json::parse(R"({
    "version": 1, "daemon_version": "1.2.3", "status": "begins", "unix_ms": 1700000060000,
    "left_out_count": 0,
    "alerts": [{
      "id": "0123456789abcdef", "rule": "ambiguous", "severity": "serious",
      "text": "No algorithm is clearly the best yet.",
      "project": "game", "scene": "harbour", "machine_class": "desktop",
      "session_count": 2, "session_ids": ["5e55", "5e56"], "loss_us": 30.5,
      "unix_since_ms": 1700000000000,
      "url": "https://dash.example/scenes/game/harbour?class=desktop&reward=3"}]})"));
}

TEST(WebhookMessageTest, AnAlertOfTheDaemonHasNoSceneAndLeadsToTheHealthView) {
  Alert alert = {.id = "1", .key = {.rule = Rule::kCheck, .check = "store", .scene = {}}};
  const nlohmann::json told = MessageOf({alert})["alerts"][0];
  EXPECT_FALSE(told.contains("project"));
  EXPECT_FALSE(told.contains("loss_us"));
  EXPECT_EQ(told["url"], "https://dash.example/health");
}

TEST(WebhookMessageTest, NamesAreEscapedInLinks) {
  const nlohmann::json told = MessageOf({SceneAlert("../a b/ü")})["alerts"][0];
  EXPECT_EQ(told["url"],
            "https://dash.example/scenes/game/~..%2Fa%20b%2F%C3%BC?class=desktop&reward=3");
}

TEST(WebhookMessageTest, WithoutAPageThereAreNoLinks) {
  EXPECT_FALSE(
      MessageOf({SceneAlert()}, {.daemon_version = "1", .page_url = ""})["alerts"][0].contains(
          "url"));
}

TEST(WebhookMessageTest, ALongListIsCutAndTheRestCounted) {
  const nlohmann::json message =
      MessageOf(std::vector<Alert>(kMaxAlertsOfMessage + 7, SceneAlert()));
  EXPECT_EQ(message["alerts"].size(), kMaxAlertsOfMessage);
  EXPECT_EQ(message["left_out_count"], 7);
}

}  // namespace
}  // namespace sweepstake::alerts
