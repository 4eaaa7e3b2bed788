// Posteriors of the daemon for people and as JSON. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/decision/math/beta_distribution.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// `width` characters from 0 to 1: '-' inside the interval, '|' the mean, ' ' outside.
std::string IntervalBar(double mean, decision::CredibleInterval interval, int width);

// A heading and a line per arm, each ending with a line break: the mean, the central 95 % of the
// posterior, the probability to be the best. The verdict is that of all sessions' evidence
// together (diagnosis.h); only the newest version of an arm's backend takes part.
std::string PosteriorText(const v1::ScenePosterior& scene);
nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene);

// "hurricane-3000: decision 7, SAP → KDTree: switched (policy), reward 0.731".
std::string DecisionText(const v1::DecisionEvent& event);

}  // namespace sweepstake::cli
