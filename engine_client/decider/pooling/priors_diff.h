// Compares what two sets of evidence say of the costs of arms, such as those of two builds of a
// game. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/pooling/priors_groups.h"

namespace sweepstake::decision {

// An arm before and after; absent where the arm has no evidence.
struct ArmComparison {
  std::string arm;
  std::optional<PriorsArm> before;
  std::optional<PriorsArm> after;

  // Returns ln(cost ratio after ÷ cost ratio before); 0 if one of them is unknown.
  double log_change() const;
  // Returns whether the cost ratio changes by more than 5 %, or is known only before or after.
  bool changed() const;
};

struct SceneComparison {
  PriorsGroupKey key;
  std::vector<ArmComparison> arms;  // ordered by name

  bool changed() const;  // an arm has changed
  bool in_both() const;  // cost ratios are known before and after
  // Returns whether other arms are the cheapest after than before. False unless in_both().
  bool leader_changed() const;
};

// Returns a comparison for each group of either set.
std::vector<SceneComparison> ComparePriors(const PriorsGroups& before, const PriorsGroups& after);

// Returns those that have changed.
std::vector<SceneComparison> DiffPriors(const PriorsGroups& before, const PriorsGroups& after);

}  // namespace sweepstake::decision
