#include "server/sessions/scene_quota.h"

#include "absl/strings/str_cat.h"
#include "engine_client/decider/session/session_setup.h"
#include "server/sessions/common/reasons.h"

namespace sweepstake::sessions {

absl::Status CheckProjectCount(uint64_t count, const HostedSessionOptions& options) {
  const uint32_t max_projects = options.max_projects;
  if (count <= max_projects) return absl::OkStatus();
  return Refused(reasons::kTooManyProjects,
                 absl::StrCat("this daemon has ", max_projects,
                              " projects, the maximum; use the same project name in every session, "
                              "or raise --max-projects"));
}

absl::Status CheckSceneCount(const priors::SceneCount& count, const HostedSessionOptions& options) {
  const uint32_t max_scenes = options.max_scenes;
  if (count.names <= max_scenes && count.keys <= uint64_t{max_scenes} * SceneQuota::kKeysPerScene)
    return absl::OkStatus();
  return Refused(
      reasons::kTooManyScenes,
      absl::StrCat("the project has ", max_scenes, " scenes, with ", SceneQuota::kKeysPerScene,
                   " machine classes on average, the maximum; use the same scene names in "
                   "every session, or raise --max-scenes"));
}

absl::Status SceneQuota::Add(const priors::SceneKey& scene, const std::string& arm,
                             uint32_t backend_version) {
  if (!scenes_.contains(scene)) {
    if (absl::Status status = AddScene(scene); !status.ok()) return status;
  }
  Scene& known = scenes_[scene];
  known.arms.insert(arm);
  known.versions.emplace(arm, backend_version);
  if (known.arms.size() <= decision::kMaxArms &&
      known.versions.size() <= decision::kMaxArms * kVersionsPerArm) {
    return absl::OkStatus();
  }
  return Refused(
      reasons::kTooManyArms,
      absl::StrCat("a scene may have ", decision::kMaxArms, " arms, with ", kVersionsPerArm,
                   " versions on average; use the same arm names in every session"));
}

absl::Status SceneQuota::AddScene(const priors::SceneKey& scene) {
  const auto stored = store_.LoadScene(scene);
  Scene& known = scenes_[scene];
  unstored_.reset();
  if (!stored.ok()) {
    unstored_.emplace();
    // A damaged scene is in the store, and so is its project. After any other error the number of
    // projects is unknown; 0 makes at least the projects in memory count.
    if (!absl::IsDataLoss(stored.status())) unstored_->project_count = 0;
    return absl::OkStatus();
  }
  if (stored->has_value()) {
    for (const auto& arm : (*stored)->arms) {
      known.arms.insert(arm.name);
      known.versions.emplace(arm.name, arm.backend_version);
      for (const auto& regime : arm.regimes) {
        if (!regime.first.empty()) known.regimes.insert(regime.first);
      }
    }
    return absl::OkStatus();
  }
  if (!counts_) {
    unstored_.emplace();
    return absl::OkStatus();
  }
  new_scenes_.push_back(scene);
  Project& project = FindProject(scene.project);
  // If the name is stored for another machine class, this scene does not add a name.
  const auto named = store_.List({scene.project, scene.scene}, std::nullopt, 1);
  unstored_ = {.stored = project.count,
               .new_name = !named.ok() || named->empty(),
               .project_count = project.project_count};
  ++project.count.keys;
  if (unstored_->new_name && new_names_.emplace(scene.project, scene.scene).second)
    ++project.count.names;
  absl::Status status = CheckSceneCount(project.count, options_);
  if (status.ok() && project.project_count)
    status = CheckProjectCount(*project.project_count + new_project_count_, options_);
  return status;
}

SceneQuota::Project& SceneQuota::FindProject(const std::string& name) {
  const auto [found, is_unknown] = projects_.try_emplace(name);
  Project& project = found->second;
  if (!is_unknown) return project;
  project.count = store_.CountScenes(name).value_or(priors::SceneCount{});
  if (project.count.keys == 0) {
    project.project_count = store_.CountProjects().value_or(0);
    ++new_project_count_;
  }
  return project;
}

}  // namespace sweepstake::sessions
