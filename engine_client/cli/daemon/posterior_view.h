// Shows a daemon's posteriors to people and as JSON. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "server/decision/math/beta_distribution.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Draws the range 0 to 1 with `width` characters: '-' inside the interval, '|' at the mean, ' '
// outside.
std::string IntervalBar(double mean, decision::CredibleInterval interval, int width);

// Returns a heading and a table with a line per arm: the mean, the central 95 % of the posterior
// and the probability of being the best arm. The verdict is computed from the evidence of all
// sessions together (server/decision/policy/diagnosis.h) and compares only the newest version of
// each arm's backend.
std::string PosteriorText(const v1::ScenePosterior& scene);
nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene);

// These show several scenes: as a text with an empty line after each scene, or as an array.
std::string PosteriorsText(std::span<const v1::ScenePosterior> scenes);
nlohmann::ordered_json PosteriorsJson(std::span<const v1::ScenePosterior> scenes);

// Returns, for example, "hurricane-3000: decision 7, SAP → KDTree: switched (policy), reward
// 0.731".
std::string DecisionText(const v1::DecisionEvent& event);

}  // namespace sweepstake::cli
