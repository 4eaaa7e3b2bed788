#include "server/rpc/sessions/scene_quota.h"

#include "absl/strings/str_cat.h"
#include "server/decision/session/session_setup.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

absl::Status SceneQuota::Add(const priors::SceneKey& scene, const ArmKey& arm) {
  if (!scenes_.contains(scene)) {
    if (absl::Status status = AddScene(scene); !status.ok()) return status;
  }
  Scene& known = scenes_[scene];
  known.arms.insert(arm.name);
  known.versions.insert(arm);
  if (known.arms.size() <= decision::kMaxArms &&
      known.versions.size() <= decision::kMaxArms * kVersionsPerArm) {
    return absl::OkStatus();
  }
  return Refused(
      v1::ERROR_REASON_TOO_MANY_ARMS,
      absl::StrCat("a scene may have ", decision::kMaxArms, " arms, of ", kVersionsPerArm,
                   " versions on average; name the arms alike in every session"));
}

absl::Status SceneQuota::AddScene(const priors::SceneKey& scene) {
  const auto stored = store_.LoadScene(scene);
  Scene& known = scenes_[scene];
  if (!stored.ok()) return absl::OkStatus();
  if (stored->has_value()) {
    for (const auto& arm : (*stored)->arms) {
      known.arms.insert(arm.name);
      known.versions.insert({arm.name, arm.backend_version});
    }
    return absl::OkStatus();
  }
  auto count = projects_.find(scene.project);
  if (count == projects_.end()) {
    count = projects_
                .emplace(scene.project,
                         store_.CountScenes(scene.project).value_or(priors::SceneCount{}))
                .first;
  }
  ++count->second.keys;
  // Another machine class of a known name adds no name.
  const auto named = store_.List({scene.project, scene.scene}, std::nullopt, 1);
  const bool is_new = !named.ok() || named->empty();
  if (is_new && new_names_.emplace(scene.project, scene.scene).second) ++count->second.names;
  if (count->second.names <= options_.max_scenes &&
      count->second.keys <= uint64_t{options_.max_scenes} * kKeysPerScene) {
    return absl::OkStatus();
  }
  return Refused(v1::ERROR_REASON_TOO_MANY_SCENES,
                 absl::StrCat("the project has ", options_.max_scenes, " scenes (max_scenes), of ",
                              kKeysPerScene,
                              " machine classes on average; name scenes alike in every session, or "
                              "raise --max-scenes"));
}

}  // namespace sweepstake::rpc
