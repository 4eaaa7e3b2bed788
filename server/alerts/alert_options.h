// The connections of the alerts to the rest of the daemon. All functions are called on the decision
// loop and must not block. Empty functions are not called.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/alerts/alert_board.h"
#include "server/alerts/alert_rules.h"
#include "server/sessions/common/adjustable.h"

namespace sweepstake::alerts {

struct AlertOptions {
  // Returns the results of the daemon's health checks.
  std::function<std::vector<CheckResult>()> checks = {};
  // Announces alerts. Not called without a change.
  std::function<void(const AlertChanges&)> announce = {};
  // Saves the text of the silences (AlertBoard::SilencesText).
  std::function<void(std::string)> save_silences = {};
  // Text of the silences to begin with, checked by AlertBoard::Restore; empty: none.
  std::string silences = {};
  // The maximum number of scenes with metrics of their own.
  sessions::Adjustable<uint32_t> max_metric_scenes = 0;
};

}  // namespace sweepstake::alerts
