// What a session has learnt of an arm, as cells of a table and as JSON: the same words wherever a
// command shows it. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/embedded_decider.h"

namespace sweepstake::cli {

// Returns "cost", "95_low", "95_high", "best", "n", "live" and "lane": the cost ÷ the leader's with
// its 95 % interval, the probability to be the best arm, the effective number of live windows, and
// the live windows and visits of the shadow lane that were learnt from.
std::vector<std::string> StandingHeader();
// Returns the cells under that header. What is not known is "-".
std::vector<std::string> StandingCells(const std::optional<ArmStanding>& standing);
// One line that explains the header to people.
std::string StandingLegend();

// Adds the keys cost_ratio, cost_ratio_95, best_probability, n, live_windows and lane_visits to
// `document`. What is not known is null.
void AddStanding(const std::optional<ArmStanding>& standing, nlohmann::ordered_json& document);

// Returns three digits: "1.28", "31.7", "1234".
std::string RatioText(double ratio);

}  // namespace sweepstake::cli
