// The output of `sweepstake priors show` and `sweepstake priors diff`: the content of a priors file
// by scene and regime, and the regimes in which two files differ.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine_client/decider/pooling/priors_diff.h"

namespace sweepstake::cli {

// Returns "project/scene" followed, if the key has them, by " on MACHINE_CLASS", " in build BUILD",
// the regime's object count, speed and share of static objects, and " (in quarantine)".
std::string NameOf(const decision::PriorsGroupKey& key);
// Returns a JSON object with the members of the key.
nlohmann::ordered_json KeyJson(const decision::PriorsGroupKey& key);

// Returns a table. Each group has a title and one row per arm. Costs are shown only for reward
// version 3.
std::string ShowText(const decision::PriorsGroups& groups);
nlohmann::ordered_json ShowJson(const decision::PriorsGroups& groups);

std::string DiffText(const std::vector<decision::SceneComparison>& changes);
nlohmann::ordered_json DiffJson(const std::vector<decision::SceneComparison>& changes);

}  // namespace sweepstake::cli
