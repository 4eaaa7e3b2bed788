// The output of `sweepstake priors show` and `diff`: the content of a priors file by scene, and the
// scenes in which two files differ.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/priors/priors_groups.h"

namespace sweepstake::cli {

// Returns a table with a title and a row per arm for each group. Costs are shown only for reward
// version 3.
std::string ShowText(const PriorsGroups& groups);
nlohmann::ordered_json ShowJson(const PriorsGroups& groups);

// An arm's cost divided by the cheapest arm's, in each of two files; absent if the file has no
// evidence of the arm.
struct ArmChange {
  std::string arm;
  std::optional<double> before;
  std::optional<double> after;
};

struct GroupChange {
  PriorsGroupKey key;
  std::vector<ArmChange> arms;

  bool in_both() const;         // whether both files have evidence of the group
  bool leader_changed() const;  // false unless in_both()
};

// Returns the groups of reward version 3 in which an arm is in only one file, or in which its cost
// ratio differs by more than 5 %.
std::vector<GroupChange> DiffPriors(const PriorsGroups& before, const PriorsGroups& after);

std::string DiffText(const std::vector<GroupChange>& changes);
nlohmann::ordered_json DiffJson(const std::vector<GroupChange>& changes);

}  // namespace sweepstake::cli
