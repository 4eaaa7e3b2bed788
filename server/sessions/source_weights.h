// Computes how much each stored record of evidence would count in the prior of a future session.
// Used on one of the store's threads.
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

// Computes the weights in an export with `with_weights`. One object reads each scene only once.
class SourceWeights {
 public:
  // `store` is borrowed.
  explicit SourceWeights(priors::PriorReader& store) : store_(store) {}

  // Returns the weight that PriorFor gives the record in a session of its scene and machine class,
  // with the latest build of that scene and machine class and the newest version of the arm.
  // Returns 0 for records that such a session does not use: in quarantine, or not chosen by
  // LoadSources. Errors: those of PriorReader::LoadSources.
  absl::StatusOr<double> Of(const priors::PriorRecord& record);

 private:
  struct Scene {
    std::map<std::string, priors::SceneSource> sources;  // of the scene's machine class, by id
    std::map<std::string, uint32_t> newest_versions;     // by arm
    std::string newest_build;
  };

  absl::StatusOr<const Scene*> Find(const priors::SceneKey& key);

  priors::PriorReader& store_;
  std::map<priors::SceneKey, Scene> scenes_;
};

}  // namespace sweepstake::sessions
