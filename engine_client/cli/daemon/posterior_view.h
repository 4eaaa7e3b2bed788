// Formats a daemon's posteriors as text and as JSON. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "engine_client/math/beta_distribution.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Draws the range 0 to 1 with `width` characters: '-' inside the interval, '|' at the mean, ' '
// outside.
std::string IntervalBar(double mean, decision::CredibleInterval interval, int width);

// Returns a heading and a table with a line per arm: the mean, the central 95 % of the posterior,
// the cost divided by the leader's if the reward version measures costs, the probability of being
// the best arm, and the windows and visits of all sessions. The daemon computes these values
// (engine_client/decider/policy/scene_diagnosis.h).
std::string PosteriorText(const v1::ScenePosterior& scene);
nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene);

// Format several scenes: as text with an empty line after each scene, or as an array.
std::string PosteriorsText(std::span<const v1::ScenePosterior> scenes);
nlohmann::ordered_json PosteriorsJson(std::span<const v1::ScenePosterior> scenes);

// Returns the value that a share of the values, 0 to 1, does not exceed, to within 4.5 %. The
// result is absent if there are no values, or if the message breaks its rules.
std::optional<double> Quantile(const v1::LogHistogram& histogram, double share);

// Returns a heading and a table of what the event's session has learnt about its arms; empty if the
// event does not contain it.
std::string StandingsText(const v1::DecisionEvent& event);
// Returns, for example, "hurricane-3000: decision 7, SAP → KDTree: switched (policy), reward 0.731;
// p50/p95/p99 of the frame 16.6/17.2/31.1 ms, detection 2.10/2.35/4.81 ms".
std::string DecisionText(const v1::DecisionEvent& event);
// Returns the values of DecisionText, and the percentiles of the memory.
nlohmann::ordered_json DecisionJson(const v1::DecisionEvent& event);

}  // namespace sweepstake::cli
