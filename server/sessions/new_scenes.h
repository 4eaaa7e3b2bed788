// The scenes of sessions in memory that the store does not have yet, and the projects of these. It
// gets them with their first evidence, so that they count against the quotas from the Hello on.
//
// Used on the decision loop only. It outlives its holds.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/common/options.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

// What the store says about a scene that it does not have. Read on its writing thread, and told to
// the loop with PostLater, it has the scenes that were forgotten here until then, and no other.
struct UnstoredScene {
  priors::SceneCount stored = {};  // what it has of the project
  bool new_name = true;  // no other machine class or reward version of it is stored, either
  // Present if it has nothing of the project, as far as is known: where the store cannot say, 0, so
  // that the projects that are held count at least.
  std::optional<uint64_t> project_count;
};

class NewScenes {
 public:
  explicit NewScenes(const RpcOptions& options) : options_(options) {}

  // One session's part in a scene. Movable.
  class Hold {
   public:
    Hold(NewScenes& scenes, priors::SceneKey scene) : scenes_(&scenes), scene_(std::move(scene)) {}
    Hold(Hold&& other) noexcept
        : scenes_(std::exchange(other.scenes_, nullptr)), scene_(std::move(other.scene_)) {}
    Hold& operator=(Hold&&) = delete;
    ~Hold() {
      if (scenes_ != nullptr) scenes_->Release(scene_);
    }
    // The store has the scene now, whoever else holds it.
    void OnStored() {
      if (scenes_ != nullptr) std::exchange(scenes_, nullptr)->Forget(scene_);
    }

   private:
    NewScenes* scenes_;
    priors::SceneKey scene_;
  };

  // Error: RESOURCE_EXHAUSTED (with this one the project would have more scenes than it may, or the
  // store more projects).
  absl::StatusOr<Hold> Take(const priors::SceneKey& scene, const UnstoredScene& unstored);

  // The store has the scene now, whoever holds it.
  void Forget(const priors::SceneKey& scene);
  // Returns how many scenes are held, of all projects.
  size_t size() const;

 private:
  struct Project {
    bool stored = false;  // the store has other scenes of it
    // How many sessions hold each.
    std::map<std::string, uint32_t> names;
    std::map<priors::SceneKey, uint32_t> keys;
  };

  absl::Status CheckProject(const std::string& project, const UnstoredScene& unstored) const;

  void Release(const priors::SceneKey& scene);

  const RpcOptions& options_;
  std::map<std::string, Project> projects_;
};

}  // namespace sweepstake::rpc
