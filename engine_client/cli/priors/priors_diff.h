// `sweepstake priors show` and `diff`: what files of priors say of each scene, and where two of
// them differ.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/priors/priors_groups.h"

namespace sweepstake::cli {

// A table with a title and a row per arm for each group; of a reward other than version 3 without
// costs.
std::string ShowText(const PriorsGroups& groups);
nlohmann::ordered_json ShowJson(const PriorsGroups& groups);

// An arm's cost ÷ the cheapest one's in one file and in the other; absent where that does not know
// it.
struct ArmChange {
  std::string arm;
  std::optional<double> before;
  std::optional<double> after;
};

struct GroupChange {
  PriorsGroupKey key;
  std::vector<ArmChange> arms;

  bool in_both() const;         // else one of the files knows nothing of the group
  bool leader_changed() const;  // of a group in both
};

// Returns the groups of reward version 3 in which an arm is in one of both alone, or its cost ratio
// differs by more than a twentieth.
std::vector<GroupChange> DiffPriors(const PriorsGroups& before, const PriorsGroups& after);

std::string DiffText(const std::vector<GroupChange>& changes);
nlohmann::ordered_json DiffJson(const std::vector<GroupChange>& changes);

}  // namespace sweepstake::cli
