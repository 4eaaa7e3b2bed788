// Posteriors of the daemon for people and as JSON. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

struct Interval {
  double low = 0;
  double high = 1;
};

// 95 % of a Beta distribution by the normal approximation, mean ± 1.96 standard deviations, cut to
// 0..1: good to 0.01 from some ten observations on, too narrow towards 0 and 1 before. All of 0..1
// where there is no evidence at all.
Interval ApproximateInterval(double alpha, double beta);

// `width` characters from 0 to 1: '-' inside the interval, '|' the mean, ' ' outside.
std::string IntervalBar(double mean, Interval interval, int width);

// A heading and a line per arm, each ending with a line break.
std::string PosteriorText(const v1::ScenePosterior& scene);
nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene);

// "hurricane-3000: decision 7, SAP → KDTree: switched (policy), reward 0.731".
std::string DecisionText(const v1::DecisionEvent& event);

}  // namespace sweepstake::cli
