// How much each source of stored evidence counts in sessions to come. It reads the store, and is
// used on one of its threads.
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

// For people who look at the sources; a scene is read once.
class SourceWeights {
 public:
  // `store` is borrowed.
  explicit SourceWeights(priors::PriorReader& store) : store_(store) {}

  // Returns how much the record counts in a new session of its scene and class of machines, which
  // plays the build of the source that was seen there last and has the newest version of the arm
  // that is known there. It is the weight that session_start.cc gives; 0 for what no such session
  // looks at: what waits in quarantine, or is not among the sources that LoadSources chooses of the
  // arm. Where rewards do not tell costs, the sums of all sources count, which is 1. Errors: those
  // of PriorReader::LoadSources.
  absl::StatusOr<double> Of(const priors::PriorRecord& record);

 private:
  struct Scene {
    std::map<std::string, priors::SceneSource> sources;  // those of its class, by id
    std::map<std::string, uint32_t> newest_versions;     // by arm
    std::string newest_build;                            // that of the source seen last
  };

  absl::StatusOr<const Scene*> Find(const priors::SceneKey& key);

  priors::PriorReader& store_;
  std::map<priors::SceneKey, Scene> scenes_;
};

}  // namespace sweepstake::rpc
