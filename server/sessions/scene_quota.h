// How much of the store clients may fill: projects, scenes of each, and arms of each scene. A
// client names all three, so that without bounds one client could make any number of them.
//
// Used on a thread of the store, for one Hello or one import.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/rpc/common/options.h"
#include "server/sessions/new_scenes.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

// An arm's name; its versions are counted apart.
struct ArmKey {
  std::string name;
  uint32_t backend_version = 1;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const ArmKey&, const ArmKey&) = default;
};

// Error: RESOURCE_EXHAUSTED (there may not be so many projects).
absl::Status CheckProjectCount(uint64_t count, const RpcOptions& options);
// Error: RESOURCE_EXHAUSTED (a project with so many scenes has more than it may).
absl::Status CheckSceneCount(const priors::SceneCount& count, const RpcOptions& options);

class SceneQuota {
 public:
  // A scene counts once by its name, and may have so many machine classes and reward versions on
  // average; an arm may have so many versions.
  static constexpr uint32_t kKeysPerScene = 32;
  static constexpr uint32_t kVersionsPerArm = 32;

  // Without `counts`, a scene that is not stored is not counted and allowed, since another look
  // will follow that counts it.
  SceneQuota(priors::PriorReader& store, const RpcOptions& options, bool counts = true)
      : store_(store), options_(options), counts_(counts) {}

  // Checks that the scene and its arm may be stored, beside what is there and what was added here
  // before. Error: RESOURCE_EXHAUSTED names the limit. A store that cannot be read allows it: what
  // it cannot read it does not write either.
  absl::Status Add(const priors::SceneKey& scene, const ArmKey& arm);
  absl::Status Add(const priors::EvidenceKey& key) {
    return Add({key.project, key.scene, key.machine_class, key.reward_version},
               {key.arm, key.backend_version});
  }

  // What the store said about the scene that was added last; absent if it has that scene.
  const std::optional<UnstoredScene>& unstored() const { return unstored_; }
  // What was added of what the store does not have.
  const std::vector<priors::SceneKey>& new_scenes() const { return new_scenes_; }

 private:
  struct Scene {
    std::set<std::string> arms;
    std::set<ArmKey> versions;
  };

  // What is known of a project.
  struct Project {
    priors::SceneCount count;               // stored, and added here
    std::optional<uint64_t> project_count;  // those stored, where this one is not
  };

  absl::Status AddScene(const priors::SceneKey& scene);
  Project& FindProject(const std::string& name);

  priors::PriorReader& store_;
  const RpcOptions& options_;
  const bool counts_;
  std::map<std::string, Project> projects_;
  uint64_t new_project_count_ = 0;                           // of these
  std::set<std::pair<std::string, std::string>> new_names_;  // of project and scene
  std::map<priors::SceneKey, Scene> scenes_;
  std::vector<priors::SceneKey> new_scenes_;
  std::optional<UnstoredScene> unstored_;
};

}  // namespace sweepstake::rpc
