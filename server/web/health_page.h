// The pages /livez and /readyz, in the form that Kubernetes' own have.
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
  std::function<std::optional<std::string>()> problem;  // nothing if all is well
  std::string note = {};  // what is worth knowing though it is no problem
};

// Returns the page called `name`: 200 if no check has a problem, else 503. It lists the checks if
// one has a problem or the query is "verbose".
Page HealthPage(std::string_view name, const std::vector<HealthCheck>& checks,
                std::string_view query);

}  // namespace sweepstake::web
