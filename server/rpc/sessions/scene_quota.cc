#include "server/rpc/sessions/scene_quota.h"

#include "absl/strings/str_cat.h"
#include "server/decision/session/session_setup.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

absl::Status CheckSceneCount(const priors::SceneCount& count, const RpcOptions& options) {
  const uint32_t max_scenes = options.max_scenes;
  if (count.names <= max_scenes && count.keys <= uint64_t{max_scenes} * SceneQuota::kKeysPerScene)
    return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TOO_MANY_SCENES,
                 absl::StrCat("the project has ", max_scenes, " scenes (max_scenes), of ",
                              SceneQuota::kKeysPerScene,
                              " machine classes on average; name scenes alike in every session, or "
                              "raise --max-scenes"));
}

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
  unstored_.reset();
  if (!stored.ok()) {
    unstored_.emplace();
    return absl::OkStatus();
  }
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
  // Another machine class of a known name adds no name.
  const auto named = store_.List({scene.project, scene.scene}, std::nullopt, 1);
  unstored_ = {.stored = count->second, .new_name = !named.ok() || named->empty()};
  ++count->second.keys;
  if (unstored_->new_name && new_names_.emplace(scene.project, scene.scene).second)
    ++count->second.names;
  return CheckSceneCount(count->second, options_);
}

}  // namespace sweepstake::rpc
