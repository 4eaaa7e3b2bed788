#include "server/rpc/common/leader_preview.h"

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::rpc {
namespace {

constexpr uint32_t kScenesPerRead = 200;

// Returns the arm whose newest version has the highest posterior mean; empty if there is no
// evidence.
std::string LeaderOf(const priors::SceneEvidence& scene) {
  std::vector<std::string_view> names;
  std::vector<decision::ArmEvidence> evidence;
  for (size_t i = 0; i < scene.arms.size(); ++i) {  // arms are ordered by name and version
    if (i + 1 < scene.arms.size() && scene.arms[i + 1].name == scene.arms[i].name) continue;
    names.push_back(scene.arms[i].name);
    evidence.push_back(EvidenceOf(scene.arms[i]));
  }
  const std::vector<decision::EvidenceSum> pooled = decision::PoolEvidence(evidence);
  std::string_view leader;
  double best = -1;
  for (size_t i = 0; i < names.size(); ++i) {
    const double mean = (1 + pooled[i].alpha) / (2 + pooled[i].evidence());
    if (!(pooled[i].evidence() > 0) || mean <= best) continue;
    leader = names[i];
    best = mean;
  }
  return std::string(leader);
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

absl::StatusOr<LeaderPreview::Leaders> LeaderPreview::Load(priors::PriorReader& store) const {
  Leaders leaders;
  std::optional<priors::SceneKey> after;
  while (leaders.size() < kMaxScenes) {
    const auto page = store.List({.project = project_, .scene = {}}, after, kScenesPerRead);
    if (!page.ok()) return page.status();
    for (const priors::SceneEvidence& scene : *page) leaders.emplace(scene.key, LeaderOf(scene));
    if (page->size() < kScenesPerRead) break;
    after = page->back().key;
  }
  return leaders;
}

absl::StatusOr<v1::LeaderChanges> LeaderPreview::Changes() const {
  if (!before_.ok()) return before_.status();
  if (!after_.ok()) return after_.status();
  std::map<priors::SceneKey, std::pair<std::string, std::string>> leaders;
  for (const auto& [scene, leader] : *before_) leaders[scene].first = leader;
  for (const auto& [scene, leader] : *after_) leaders[scene].second = leader;
  // If there are more than kMaxScenes, ignore scenes beyond the last one that both sides have read.
  for (const Leaders* side : {&*before_, &*after_}) {
    if (side->size() >= kMaxScenes)
      leaders.erase(leaders.upper_bound(side->rbegin()->first), leaders.end());
  }
  v1::LeaderChanges changes;
  for (const auto& [scene, arms] : leaders) {
    if (arms.first == arms.second) continue;
    changes.set_scene_count(changes.scene_count() + 1);
    if (changes.scenes_size() == kMaxTold) continue;
    v1::LeaderChange& change = *changes.add_scenes();
    change.set_project(scene.project);
    change.set_scene(scene.scene);
    change.set_machine_class(scene.machine_class);
    change.set_reward_version(scene.reward_version);
    change.set_arm(arms.first);
    change.set_next_arm(arms.second);
  }
  return changes;
}

}  // namespace sweepstake::rpc
