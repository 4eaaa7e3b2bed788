#include "server/rpc/common/leader_preview.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine_client/decider/pooling/scene_pool.h"

namespace sweepstake::rpc {
namespace {

using Arm = priors::SceneEvidence::Arm;

constexpr uint32_t kScenesPerRead = 200;

// Returns the leader's name; empty if there is no evidence.
std::string LeaderOf(const priors::SceneKey& key, std::span<const Arm> arms) {
  const auto leader = decision::LeaderOf(priors::Pool(arms).arms, key.reward_version);
  return leader ? arms[*leader].name : std::string();
}

}  // namespace

LeaderPreview::LeaderPreview(priors::PriorReader& store, std::string project, bool is_preview)
    : project_(std::move(project)), is_preview_(is_preview) {
  if (is_preview_) before_ = Load(store);
}

priors::Preview LeaderPreview::preview() {
  if (!is_preview_ || !before_.ok()) return is_preview_;
  return priors::Preview([this](priors::PriorReader& store) { after_ = Load(store); });
}

absl::StatusOr<LeaderPreview::Scenes> LeaderPreview::Load(priors::PriorReader& store) const {
  Scenes scenes;
  std::optional<priors::SceneKey> after;
  while (scenes.size() < kMaxScenes) {
    auto page = store.List({.project = project_, .scene = {}}, after, kScenesPerRead);
    if (!page.ok()) return page.status();
    const bool is_last = page->size() < kScenesPerRead;
    if (!page->empty()) after = page->back().key;
    for (priors::SceneEvidence& scene : *page)
      scenes.emplace(std::move(scene.key), std::move(scene.arms));
    if (is_last) break;
  }
  return scenes;
}

absl::StatusOr<v1::LeaderChanges> LeaderPreview::Changes() const {
  if (!before_.ok()) return before_.status();
  if (!after_.ok()) return after_.status();
  std::map<priors::SceneKey, std::pair<std::span<const Arm>, std::span<const Arm>>> scenes;
  for (const auto& [scene, arms] : *before_) scenes[scene].first = arms;
  for (const auto& [scene, arms] : *after_) scenes[scene].second = arms;
  // If there are more than kMaxScenes, ignore scenes beyond the last one that both sides have read.
  for (const Scenes* side : {&*before_, &*after_}) {
    if (side->size() >= kMaxScenes)
      scenes.erase(scenes.upper_bound(side->rbegin()->first), scenes.end());
  }
  v1::LeaderChanges changes;
  for (const auto& [scene, arms] : scenes) {
    if (std::ranges::equal(arms.first, arms.second)) continue;  // then the leader is the same
    const std::string before = LeaderOf(scene, arms.first);
    const std::string after = LeaderOf(scene, arms.second);
    if (before == after) continue;
    changes.set_scene_count(changes.scene_count() + 1);
    if (changes.scenes_size() == kMaxTold) continue;
    v1::LeaderChange& change = *changes.add_scenes();
    change.set_project(scene.project);
    change.set_scene(scene.scene);
    change.set_machine_class(scene.machine_class);
    change.set_reward_version(scene.reward_version);
    change.set_arm(before);
    change.set_next_arm(after);
  }
  return changes;
}

}  // namespace sweepstake::rpc
