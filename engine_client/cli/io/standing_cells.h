// Formats what a session has learnt about an arm, as table cells and as JSON. All commands use the
// same format. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/embedded_decider.h"

namespace sweepstake::cli {

// Returns the header cells:
// - "cost", "95_low", "95_high": the cost ÷ the leader's cost, and its 95 % interval
// - "best": the probability of being the best arm
// - "equiv": the equivalent number of live windows (ArmStanding::effective_window_count)
// - "live", "lane": the live windows and the shadow lane's visits in the evidence
std::vector<std::string> StandingHeader();
// Returns the cells below that header. "-" stands for an unknown value.
std::vector<std::string> StandingCells(const std::optional<ArmStanding>& standing);
// Returns three lines that explain the header.
std::string StandingLegend();

// Adds the keys cost_ratio, cost_ratio_95, best_probability, n, live_windows and lane_visits to
// `document`. An unknown value is null.
void AddStanding(const std::optional<ArmStanding>& standing, nlohmann::ordered_json& document);

// Returns the ratio with at least three digits: "1.28", "31.7", "1234".
std::string RatioText(double ratio);

}  // namespace sweepstake::cli
