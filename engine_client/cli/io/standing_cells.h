// Formats what a session has learnt about an arm as table cells and as JSON, identically in all
// commands. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/embedded_decider.h"

namespace sweepstake::cli {

// Returns "cost", "95_low", "95_high", "best", "n", "live" and "lane": the cost divided by the
// leader's with its 95 % interval, the probability of being the best arm, the effective number of
// live windows, and the live windows and shadow-lane visits in the evidence.
std::vector<std::string> StandingHeader();
// Returns the cells under that header. An unknown value is "-".
std::vector<std::string> StandingCells(const std::optional<ArmStanding>& standing);
// Returns two lines that explain the header.
std::string StandingLegend();

// Adds the keys cost_ratio, cost_ratio_95, best_probability, n, live_windows and lane_visits to
// `document`. An unknown value is null.
void AddStanding(const std::optional<ArmStanding>& standing, nlohmann::ordered_json& document);

// Returns the ratio with at least three digits: "1.28", "31.7", "1234".
std::string RatioText(double ratio);

}  // namespace sweepstake::cli
