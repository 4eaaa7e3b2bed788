// Tells watchers about changes: decisions at once, posteriors when their evidence is on disk.
//
// A posterior is Beta(1,1) plus all committed evidence in the store, which is one group commit (50
// ms) later than the decision. It is read once per change, however many watchers the scene has, and
// not at all if it has none. The hub is used on the decision loop only.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <set>

#include "absl/status/status.h"
#include "server/priors/prior_store.h"
#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::rpc {

class PosteriorWatcher;

class WatchHub final : public SessionListener {
 public:
  explicit WatchHub(ServiceContext& context) : context_(context) {}

  // Errors: RESOURCE_EXHAUSTED (there are RpcOptions::max_watchers already), UNAVAILABLE
  // (draining).
  absl::Status Add(PosteriorWatcher& watcher);
  void Remove(PosteriorWatcher& watcher) { watchers_.erase(&watcher); }

  bool WatchesDecisionsOf(const priors::SceneKey& scene) const override;
  void OnDecision(const priors::SceneKey& scene, const v1::DecisionEvent& event) override;
  void OnEvidence(const priors::SceneKey& scene) override;
  // Called after an import, which may have changed any scene: all watchers send all scenes again.
  void OnImport();
  void Drain();

  // Returns the message with the scene's posterior.
  grpc::ByteBuffer Encode(const priors::SceneEvidence& scene) const;

 private:
  void Load(const priors::SceneKey& scene);
  void OnLoaded(const priors::SceneKey& key,
                const absl::StatusOr<std::optional<priors::SceneEvidence>>& scene);
  void Tell(const priors::SceneKey& scene, const grpc::ByteBuffer& event);

  ServiceContext& context_;
  std::set<PosteriorWatcher*> watchers_;
  std::set<priors::SceneKey> loading_;  // scenes that the store is reading
  std::set<priors::SceneKey> changed_;  // scenes that changed while they were being read
  bool draining_ = false;
};

}  // namespace sweepstake::rpc
