// A watcher of the scenes of one project, which stores what the hub published last.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>

#include "server/rpc/common/access_control.h"
#include "server/watch/watch_hub.h"

namespace sweepstake::simulation {

class SimulatedWatcher final : public watch::WatchListener {
 public:
  // `complain` is called for each violation.
  SimulatedWatcher(auth::Principal caller, std::function<void(const std::string&)> complain)
      : caller_(std::move(caller)), complain_(std::move(complain)) {
    if (!rpc::Narrow(caller_, filter_).ok()) complain_("a watcher may not watch");
  }

  const priors::SceneFilter& filter() const { return filter_; }
  // By scene, since the last reset.
  const std::map<priors::SceneKey, priors::SceneEvidence>& latest() const { return latest_; }

  bool Watches(const priors::SceneKey& scene) override {
    return filter_.Matches(scene.project, scene.scene);
  }
  void OnDecision(const sessions::DecisionEvent& event) override {
    Check(event.session.scene.project);
  }
  void OnTick() override {}
  void OnPosterior(const priors::SceneEvidence& scene) override {
    Check(scene.key.project);
    latest_.insert_or_assign(scene.key, scene);
  }
  void OnReset() override { latest_.clear(); }

 private:
  void Check(const std::string& project) const {
    if (!caller_.MayUse(project)) complain_("a watcher received another project");
  }

  const auth::Principal caller_;
  const std::function<void(const std::string&)> complain_;
  priors::SceneFilter filter_;
  std::map<priors::SceneKey, priors::SceneEvidence> latest_;
};

}  // namespace sweepstake::simulation
