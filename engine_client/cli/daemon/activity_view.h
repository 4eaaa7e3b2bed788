// Formats what the sessions of a scene run, and the regimes of the scene, as text and as JSON. Pure
// functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Returns what runs and since when, what was saved per frame, and a table with a line per regime
// and one for all of them. Columns: the regime's typical object count, speed and share of static
// objects, its share of the frames, its best arm with its probability and its cost with the central
// 95 %, the detection time of what ran, and the saving against the best single arm. Without a
// connected session returns one line that says so.
std::string ActivityText(const v1::ScenePosterior& scene);
// Returns null without a connected session.
nlohmann::ordered_json ActivityJson(const v1::ScenePosterior& scene);

}  // namespace sweepstake::cli
