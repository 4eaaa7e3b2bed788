#include "engine_client/decider/pooling/build_family.h"

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

namespace sweepstake::decision {

BuildFamily::BuildFamily(std::string build, std::span<const priors::Build> family) {
  std::map<std::string, std::vector<std::string>> neighbours;
  for (const priors::Build& one : family) {
    for (const std::string& parent : one.parents) {
      neighbours[one.name].push_back(parent);
      neighbours[parent].push_back(one.name);
    }
  }
  std::deque<std::string> next = {std::move(build)};
  steps_[next.front()] = 0;
  for (; !next.empty(); next.pop_front()) {
    const int steps = steps_.at(next.front()) + 1;
    for (const std::string& neighbour : neighbours[next.front()]) {
      if (steps_.emplace(neighbour, steps).second) next.push_back(neighbour);
    }
  }
}

double BuildFamily::WeightOf(const std::string& other) const {
  const auto found = steps_.find(other);
  if (found == steps_.end()) return steps_.size() == 1 ? kOtherBuildWeight : kOtherBranchWeight;
  double weight = kSameBuildWeight;
  for (int step = 0; step < found->second; ++step) weight *= kStepFactor;
  return std::max(weight, kOtherBranchWeight);
}

}  // namespace sweepstake::decision
