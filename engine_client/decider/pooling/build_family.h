// How much what one build of a game taught counts for another: by how many steps there are from one
// to the other, a step being from a build to what it was made from, or back. Pure functions.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>

#include "engine_client/decider/pooling/build_lineage.h"

namespace sweepstake::decision {

// The weights of a power prior on the same class of machines.
inline constexpr double kSameBuildWeight = 0.5;
inline constexpr double kStepFactor = 0.8;           // for each step
inline constexpr double kOtherBranchWeight = 0.125;  // and the least of what is related
inline constexpr double kOtherBuildWeight = 0.25;    // where nothing is known to be related

class BuildFamily {
 public:
  // Of a build that nothing is known to be related to.
  explicit BuildFamily(std::string build) : BuildFamily(std::move(build), {}) {}
  // `family` is what was told of the build, of the others and of what both were made from.
  BuildFamily(std::string build, std::span<const priors::Build> family);

  // Returns how much of what the other build taught counts.
  double WeightOf(const std::string& other) const;

 private:
  std::map<std::string, int> steps_;  // to each build of the family
};

}  // namespace sweepstake::decision
