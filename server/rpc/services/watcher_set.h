// All streams of watchers: passes on what the hub tells, encoded once however many they are. Used
// on the decision loop only.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <set>

#include "absl/status/status.h"
#include "server/priors/prior_store.h"
#include "server/rpc/services/service_context.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::rpc {

class PosteriorWatcher;

// How a hub runs its tasks on the decision loop.
watch::WatchHub::Loop HubLoop(DecisionLoop& loop);

class WatcherSet final : public watch::WatchListener {
 public:
  explicit WatcherSet(ServiceContext& context) : context_(context) {}

  // Errors: RESOURCE_EXHAUSTED (there are RpcOptions::max_watchers already), UNAVAILABLE
  // (draining).
  absl::Status Add(PosteriorWatcher& watcher);
  void Remove(PosteriorWatcher& watcher);

  bool Watches(const priors::SceneKey& scene) const override;
  void OnDecision(const priors::SceneKey& scene, const v1::DecisionEvent& event) override;
  void OnPosterior(const priors::SceneEvidence& scene) override;
  // All watchers read all their scenes again.
  void OnReset() override;
  void Drain();
  // Ends the streams of callers whose tokens are not valid any more.
  void EndRefused();

  // Returns the message with the scene's posterior.
  grpc::ByteBuffer Encode(const priors::SceneEvidence& scene) const;

 private:
  // Calls `tell` with each watcher. A watcher that ends may remove itself meanwhile.
  template <typename Tell>
  void ForEach(Tell tell) {
    for (auto next = watchers_.begin(); next != watchers_.end();) tell(**next++);
  }

  ServiceContext& context_;
  std::set<PosteriorWatcher*> watchers_;
  bool draining_ = false;
};

}  // namespace sweepstake::rpc
