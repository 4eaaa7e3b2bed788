// Tells watchers what changes: decisions at once, posteriors when their evidence is on disk.
//
// A posterior is what the store has: Beta(1,1) plus all committed evidence, one group commit (50
// ms) later than the decision. It is read back once per change, however many watchers the scene
// has, and not at all when it has none. The hub lives on the decision loop only.
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

  // RESOURCE_EXHAUSTED: RpcOptions::max_watchers are there. UNAVAILABLE: draining.
  absl::Status Add(PosteriorWatcher& watcher);
  void Remove(PosteriorWatcher& watcher) { watchers_.erase(&watcher); }

  bool WatchesDecisionsOf(const priors::SceneKey& scene) const override;
  void OnDecision(const priors::SceneKey& scene, const v1::DecisionEvent& event) override;
  void OnEvidence(const priors::SceneKey& scene) override;
  // Tells all watchers everything anew: any scene may have changed.
  void OnImport();
  void Drain();

  // The message that tells a watcher the scene's posterior.
  grpc::ByteBuffer Encode(const priors::SceneEvidence& scene) const;

 private:
  void Load(const priors::SceneKey& scene);
  void OnLoaded(const priors::SceneKey& key,
                const absl::StatusOr<std::optional<priors::SceneEvidence>>& scene);
  void Tell(const priors::SceneKey& scene, const grpc::ByteBuffer& event);

  ServiceContext& context_;
  std::set<PosteriorWatcher*> watchers_;
  std::set<priors::SceneKey> loading_;  // the store is reading them
  std::set<priors::SceneKey> changed_;  // changed while they were being read
  bool draining_ = false;
};

}  // namespace sweepstake::rpc
