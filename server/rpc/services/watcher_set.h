// Everybody who watches posteriors: passes on what the hub tells, encoded once however many they
// are. Used on the decision loop only.
#pragma once

#include <map>

#include "server/rpc/services/watcher.h"
#include "server/sessions/prior_store.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::rpc {

class PosteriorWatcher;

// How a hub runs its tasks on the decision loop.
watch::WatchHub::Loop HubLoop(sessions::DecisionLoop& loop);

class WatcherSet final : public watch::WatchListener {
 public:
  explicit WatcherSet(ServiceContext& context) : context_(context), group_(context) {}

  WatcherGroup<PosteriorWatcher>& group() { return group_; }

  bool Watches(const priors::SceneKey& scene) override;
  void OnDecision(const sessions::DecisionEvent& event) override;
  void OnTick() override;
  void OnPosterior(const priors::SceneEvidence& scene) override;
  // All watchers read all their scenes again.
  void OnReset() override;

  // Returns the message with the scene's posterior.
  grpc::ByteBuffer Encode(v1::ScenePosterior scene) const;
  // Returns the message that all scenes have been told.
  grpc::ByteBuffer EncodeMark() const;

 private:
  // Passes on the scene's decisions.
  void TellDecisions(const priors::SceneKey& scene, v1::WatchPosteriorsResponse& waiting);

  ServiceContext& context_;
  WatcherGroup<PosteriorWatcher> group_;
  std::map<priors::SceneKey, v1::WatchPosteriorsResponse> decisions_;  // since the last tick
};

}  // namespace sweepstake::rpc
