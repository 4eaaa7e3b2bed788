// Compares the arms' costs according to two sets of evidence, for example of two builds of a game.
// Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/pooling/priors_groups.h"

namespace sweepstake::decision {

// Returns the arm's cost ratio; absent if it is unknown.
std::optional<double> RatioOf(const std::optional<PriorsArm>& arm);

// The evidence about an arm in the first set and in the second set; absent where there is none.
struct ArmComparison {
  std::string arm;
  std::optional<PriorsArm> before;
  std::optional<PriorsArm> after;

  // Returns ln(cost ratio after ÷ cost ratio before); 0 if one of the ratios is unknown.
  double log_change() const;
  // Returns whether the cost ratio changes by more than 5 %, or is known only before or after.
  bool changed() const;
};

struct SceneComparison {
  PriorsGroupKey key;
  std::vector<ArmComparison> arms;  // ordered by name

  bool changed() const;  // at least one arm changed()
  bool in_both() const;  // each set has the cost ratio of at least one arm
  // Returns whether the leaders differ between the two sets. False unless in_both().
  bool leader_changed() const;
};

// Returns one comparison for each group that occurs in either set.
std::vector<SceneComparison> ComparePriors(const PriorsGroups& before, const PriorsGroups& after);

// Returns only the comparisons for which changed() is true.
std::vector<SceneComparison> DiffPriors(const PriorsGroups& before, const PriorsGroups& after);

}  // namespace sweepstake::decision
