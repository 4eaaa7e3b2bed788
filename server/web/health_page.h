// The pages /livez and /readyz, in the format of Kubernetes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_message.h"

namespace sweepstake::web {

// One condition of health.
struct HealthCheck {
  std::string name;
  std::function<std::optional<std::string>()> problem;  // nothing if the check passes
  std::string note = {};                                // a remark on a check that passes
};

// Returns the page called `name`: 200 if no check has a problem, else 503. It lists the checks if
// one has a problem or the query is "verbose".
Page HealthPage(std::string_view name, const std::vector<HealthCheck>& checks,
                std::string_view query);

}  // namespace sweepstake::web
