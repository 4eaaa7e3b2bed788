#include "server/sessions/new_scenes.h"

#include <algorithm>

#include "server/sessions/scene_quota.h"

namespace sweepstake::sessions {
namespace {

template <typename Counts, typename Key>
void ReleaseOne(Counts& counts, const Key& key) {
  const auto found = counts.find(key);
  if (found != counts.end() && --found->second == 0) counts.erase(found);
}

}  // namespace

absl::Status NewScenes::CheckProject(const std::string& project,
                                     const UnstoredScene& unstored) const {
  if (!unstored.project_count || projects_.contains(project)) return absl::OkStatus();
  const auto held = std::count_if(projects_.begin(), projects_.end(),
                                  [](const auto& entry) { return !entry.second.stored; });
  return CheckProjectCount(*unstored.project_count + static_cast<uint64_t>(held) + 1, options_);
}

absl::StatusOr<NewScenes::Hold> NewScenes::Take(const priors::SceneKey& scene,
                                                const UnstoredScene& unstored) {
  if (absl::Status status = CheckProject(scene.project, unstored); !status.ok()) return status;
  const auto project = projects_.find(scene.project);
  priors::SceneCount count = unstored.stored;
  bool adds_name = unstored.new_name;
  bool adds_key = true;
  if (project != projects_.end()) {
    count.names += project->second.names.size();
    count.keys += project->second.keys.size();
    adds_name = adds_name && !project->second.names.contains(scene.scene);
    adds_key = !project->second.keys.contains(scene);
  }
  count.names += adds_name ? 1 : 0;
  count.keys += adds_key ? 1 : 0;
  if (adds_name || adds_key) {
    if (absl::Status status = CheckSceneCount(count, options_); !status.ok()) return status;
  }
  Project& held = projects_[scene.project];
  held.stored = held.stored || !unstored.project_count;
  if (unstored.new_name) ++held.names[scene.scene];
  ++held.keys[scene];
  return Hold(*this, scene);
}

void NewScenes::Release(const priors::SceneKey& scene) {
  const auto project = projects_.find(scene.project);
  if (project == projects_.end()) return;
  ReleaseOne(project->second.names, scene.scene);
  ReleaseOne(project->second.keys, scene);
  if (project->second.keys.empty()) projects_.erase(project);
}

void NewScenes::Forget(const priors::SceneKey& scene) {
  const auto project = projects_.find(scene.project);
  if (project == projects_.end()) return;
  project->second.stored = true;
  project->second.names.erase(scene.scene);
  project->second.keys.erase(scene);
  if (project->second.keys.empty()) projects_.erase(project);
}

size_t NewScenes::size() const {
  size_t count = 0;
  for (const auto& [name, project] : projects_) count += project.keys.size();
  return count;
}

}  // namespace sweepstake::sessions
