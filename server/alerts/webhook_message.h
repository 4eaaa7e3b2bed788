// The JSON message of the webhook. deploy/OPERATING.md documents its form. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "server/alerts/alert.h"

namespace sweepstake::alerts {

// Changes only if programs that read the messages must change.
inline constexpr int kWebhookVersion = 1;
// Further alerts of a message are only counted.
inline constexpr size_t kMaxAlertsOfMessage = 100;

struct WebhookContext {
  std::string daemon_version;
  std::string page_url = {};  // URL of the dashboard without a trailing slash; empty: no links
};

// `status` is "begins" or "ends".
std::string WebhookMessage(const char* status, std::span<const Alert> alerts, int64_t unix_now_ms,
                           const WebhookContext& context);

}  // namespace sweepstake::alerts
