// Formats a daemon's posteriors as text and as JSON. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "engine_client/math/beta_distribution.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Draws the range from 0 to 1 with `width` characters: '|' at the mean, '-' in the rest of the
// interval, ' ' outside.
std::string IntervalBar(double mean, decision::CredibleInterval interval, int width);

// Returns a heading, what the scene's sessions run (activity_view.h), and a table with one line per
// arm. Columns: the mean, the central 95 % of the posterior, the cost ÷ the leader's cost (if the
// reward version measures costs), the probability of being the best arm, and the windows and visits
// of all sessions. The daemon computes these values
// (engine_client/decider/policy/scene_diagnosis.h).
std::string PosteriorText(const v1::ScenePosterior& scene);
nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene);

// Format several scenes: as text with an empty line after each scene, or as a JSON array.
std::string PosteriorsText(std::span<const v1::ScenePosterior> scenes);
nlohmann::ordered_json PosteriorsJson(std::span<const v1::ScenePosterior> scenes);

// Returns a heading and a table of what the event's session has learnt about its arms. Empty if the
// event does not contain that.
std::string StandingsText(const v1::DecisionEvent& event);
// Returns one decision as text, such as "hurricane-3000: decision 7, SAP → KDTree: switched
// (policy), reward 0.731; p50/p95/p99 of the frame 16.6/17.2/31.1 ms, detection 2.10/2.35/4.81 ms".
std::string DecisionText(const v1::DecisionEvent& event);
// Returns the values of DecisionText, and percentiles of the memory.
nlohmann::ordered_json DecisionJson(const v1::DecisionEvent& event);

}  // namespace sweepstake::cli
