// The scenes of sessions in memory that are not in the store yet, and their projects. A scene
// enters the store with its first evidence, but counts against the quotas from the Hello on.
//
// Used on the decision loop only. It must outlive its holds.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

// The numbers of stored scenes and projects, for the quota check of a scene that is not stored.
// They are read on the store's writing thread and posted to the loop with PostLater. Before the
// loop uses them, NewScenes::Forget has run for every scene that they include. No scene is
// therefore counted both here and in NewScenes.
struct UnstoredScene {
  priors::SceneCount stored = {};  // stored scenes of the project
  // Whether no scene of this name is stored, for any machine class or reward version.
  bool new_name = true;
  // Number of stored projects; absent if this project is stored. 0 if the store cannot be read, so
  // that at least the projects in memory count.
  std::optional<uint64_t> project_count;
};

class NewScenes {
 public:
  explicit NewScenes(const HostedSessionOptions& options) : options_(options) {}

  // One session's claim to a scene that is not stored yet. The scene counts against the quotas
  // while a hold of it exists. Movable.
  class Hold {
   public:
    Hold(NewScenes& scenes, priors::SceneKey scene) : scenes_(&scenes), scene_(std::move(scene)) {}
    Hold(Hold&& other) noexcept
        : scenes_(std::exchange(other.scenes_, nullptr)), scene_(std::move(other.scene_)) {}
    Hold& operator=(Hold&&) = delete;
    ~Hold() {
      if (scenes_ != nullptr) scenes_->Release(scene_);
    }
    // Called when the store has the scene. Ends all holds of it.
    void OnStored() {
      if (scenes_ != nullptr) std::exchange(scenes_, nullptr)->Forget(scene_);
    }

   private:
    NewScenes* scenes_;
    priors::SceneKey scene_;
  };

  // Checks the quotas, and returns a hold of the scene. Error: RESOURCE_EXHAUSTED (the project
  // would have too many scenes, or the store too many projects).
  absl::StatusOr<Hold> Take(const priors::SceneKey& scene, const UnstoredScene& unstored);

  // Called when the store has the scene. Ends all holds of it.
  void Forget(const priors::SceneKey& scene);
  // Returns how many scenes are held, over all projects.
  size_t size() const;

 private:
  struct Project {
    bool stored = false;  // whether other scenes of the project are stored
    // The number of sessions that hold each scene.
    std::map<std::string, uint32_t> names;
    std::map<priors::SceneKey, uint32_t> keys;
  };

  absl::Status CheckProject(const std::string& project, const UnstoredScene& unstored) const;

  void Release(const priors::SceneKey& scene);

  const HostedSessionOptions& options_;
  std::map<std::string, Project> projects_;
};

}  // namespace sweepstake::sessions
