// Limits how much of the store clients may fill: projects, scenes per project, and arms per scene.
// Clients choose all three names, so without limits one client could create any number of them.
//
// Used on a thread of the store, for one Hello or one import.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/sessions/common/options.h"
#include "server/sessions/new_scenes.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

// Error: RESOURCE_EXHAUSTED (`count` exceeds the maximum number of projects).
absl::Status CheckProjectCount(uint64_t count, const HostedSessionOptions& options);
// Error: RESOURCE_EXHAUSTED (`count` exceeds the maximum number of scenes of a project).
absl::Status CheckSceneCount(const priors::SceneCount& count, const HostedSessionOptions& options);

class SceneQuota {
 public:
  // max_scenes limits the names of scenes. A name can be stored with several machine classes and
  // reward versions: kKeysPerScene limits these combinations, on average over the project.
  // kVersionsPerArm limits the versions of an arm, on average over the arms of a scene.
  static constexpr uint32_t kKeysPerScene = 32;
  static constexpr uint32_t kVersionsPerArm = 32;

  // If `counts` is false, a scene that is not stored is allowed without counting. The caller must
  // then check it again with `counts` set, on the writing thread.
  SceneQuota(priors::PriorReader& store, const HostedSessionOptions& options, bool counts = true)
      : store_(store), options_(options), counts_(counts) {}

  // Checks whether the quotas allow this scene and arm in addition to the stored ones and those
  // added before. Error: RESOURCE_EXHAUSTED, whose message names the limit. If the store cannot be
  // read, everything is allowed, because the store does not accept writes then either.
  absl::Status Add(const priors::SceneKey& scene, const std::string& arm, uint32_t backend_version);
  absl::Status Add(const priors::EvidenceKey& key) {
    return Add({key.project, key.scene, key.machine_class, key.reward_version}, key.arm,
               key.backend_version);
  }

  // The store's counts for the scene that was added last; absent if that scene is stored.
  const std::optional<UnstoredScene>& unstored() const { return unstored_; }
  // The buckets of the scene's stored regimes. REQUIRES: Add was called for the scene.
  const std::set<std::string>& regimes(const priors::SceneKey& scene) const {
    return scenes_.at(scene).regimes;
  }
  // Scenes passed to Add that are not in the store.
  const std::vector<priors::SceneKey>& new_scenes() const { return new_scenes_; }

 private:
  struct Scene {
    std::set<std::string> arms;
    std::set<std::pair<std::string, uint32_t>> versions;
    std::set<std::string> regimes;
  };

  struct Project {
    priors::SceneCount count;               // scenes stored, plus scenes added here
    std::optional<uint64_t> project_count;  // stored projects; absent if this project is stored
  };

  absl::Status AddScene(const priors::SceneKey& scene);
  Project& FindProject(const std::string& name);

  priors::PriorReader& store_;
  const HostedSessionOptions& options_;
  const bool counts_;
  std::map<std::string, Project> projects_;
  uint64_t new_project_count_ = 0;                           // new projects in projects_
  std::set<std::pair<std::string, std::string>> new_names_;  // pairs of project and scene
  std::map<priors::SceneKey, Scene> scenes_;
  std::vector<priors::SceneKey> new_scenes_;
  std::optional<UnstoredScene> unstored_;
};

}  // namespace sweepstake::sessions
