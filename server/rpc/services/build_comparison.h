// Compares what two choices of builds have measured, scene by scene (PriorsService.CompareBuilds).
// Not thread-safe.
#pragma once

#include <utility>

#include "engine_client/decider/pooling/priors_sums.h"
#include "sweepstake/v1/priors.pb.h"

namespace sweepstake::rpc {

class BuildComparison {
 public:
  explicit BuildComparison(v1::CompareBuildsRequest request) : request_(std::move(request)) {}

  // Adds a record that counts. Appends the scenes that have ended to the response. REQUIRES: the
  // records of a scene come one after the other.
  void Add(PriorRecord record, v1::CompareBuildsResponse& response);

  // Appends the last scene to the response.
  void EndScene(v1::CompareBuildsResponse& response);

 private:
  const v1::CompareBuildsRequest request_;
  BuildSums sums_;  // of the scene
  EvidenceKey scene_;
};

}  // namespace sweepstake::rpc
