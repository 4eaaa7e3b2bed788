#include "server/rpc/common/leader_preview.h"

#include <optional>
#include <utility>

#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

constexpr uint32_t kScenesPerRead = 200;

// Returns the arm that has the best mean in its newest version; empty if nothing is known.
std::string LeaderOf(const priors::SceneEvidence& scene) {
  v1::ScenePosterior told;
  ToProto(scene, told);
  std::string leader;
  double best = -1;
  for (int i = 0; i < told.arms_size(); ++i) {  // ordered by name and version
    const v1::ArmPosterior& arm = told.arms(i);
    if (i + 1 < told.arms_size() && told.arms(i + 1).arm() == arm.arm()) continue;
    const double weight = arm.posterior().alpha() + arm.posterior().beta();
    const double mean = arm.posterior().alpha() / weight;
    if (weight <= 2 || mean <= best) continue;
    leader = arm.arm();
    best = mean;
  }
  return leader;
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
  // Where there are more, scenes that one side has not read are no change.
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
