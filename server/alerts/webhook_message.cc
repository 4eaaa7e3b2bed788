#include "server/alerts/webhook_message.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace sweepstake::alerts {
namespace {

std::string Escaped(std::string_view name) {
  std::string escaped;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (absl::ascii_isalnum(byte) || std::string_view("-_.~").find(c) != std::string_view::npos) {
      escaped += c;
    } else {
      absl::StrAppendFormat(&escaped, "%%%02X", byte);
    }
  }
  return escaped;
}

// Returns a name as a part of a path. pathPart in dashboard/src/live/state/route.ts has the same
// rule.
std::string PathPart(const std::string& name) {
  const bool is_special = name.starts_with('.') || name.starts_with('~');
  return absl::StrCat(is_special ? "~" : "", Escaped(name));
}

std::string UrlOf(const Alert& alert, const std::string& page_url) {
  const priors::SceneKey& scene = alert.key.scene;
  if (scene.project.empty()) return page_url + "/health";
  return absl::StrCat(page_url, "/scenes/", PathPart(scene.project), "/", PathPart(scene.scene),
                      scene.machine_class.empty()
                          ? "?"
                          : absl::StrCat("?class=", Escaped(scene.machine_class), "&"),
                      "reward=", scene.reward_version);
}

nlohmann::json JsonOf(const Alert& alert, const std::string& page_url) {
  const Finding& finding = alert.finding;
  nlohmann::json json = {{"id", alert.id},
                         {"rule", NameOf(alert.key.rule)},
                         {"severity", NameOf(finding.severity)},
                         {"text", finding.text},
                         {"unix_since_ms", alert.unix_since_ms}};
  const priors::SceneKey& scene = alert.key.scene;
  if (!scene.project.empty()) {
    json["project"] = scene.project;
    json["scene"] = scene.scene;
    json["machine_class"] = scene.machine_class;
    json["session_count"] = finding.session_count;
    json["session_ids"] = finding.session_ids;
  }
  if (finding.loss_us) json["loss_us"] = *finding.loss_us;
  if (!page_url.empty()) json["url"] = UrlOf(alert, page_url);
  return json;
}

}  // namespace

std::string WebhookMessage(const char* status, std::span<const Alert> alerts, int64_t unix_now_ms,
                           const WebhookContext& context) {
  const auto told = alerts.first(std::min(alerts.size(), kMaxAlertsOfMessage));
  nlohmann::json list = nlohmann::json::array();
  for (const Alert& alert : told) list.push_back(JsonOf(alert, context.page_url));
  return nlohmann::json{
      {"version", kWebhookVersion}, {"daemon_version", context.daemon_version},
      {"status", status},           {"unix_ms", unix_now_ms},
      {"alerts", std::move(list)},  {"left_out_count", alerts.size() - told.size()}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace sweepstake::alerts
