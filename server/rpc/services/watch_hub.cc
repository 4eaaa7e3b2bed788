#include "server/rpc/services/watch_hub.h"

#include <algorithm>

#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/posterior_watcher.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {

absl::Status WatchHub::Add(PosteriorWatcher& watcher) {
  if (draining_) return absl::UnavailableError("the daemon is draining; watch again later");
  if (watchers_.size() >= context_.options.max_watchers) {
    return absl::ResourceExhaustedError(
        "this daemon has as many watchers as it may; try again later");
  }
  watchers_.insert(&watcher);
  return absl::OkStatus();
}

bool WatchHub::WatchesDecisionsOf(const priors::SceneKey& scene) const {
  return std::any_of(watchers_.begin(), watchers_.end(),
                     [&](const auto* watcher) { return watcher->Watches(scene); });
}

void WatchHub::OnDecision(const priors::SceneKey& scene, const v1::DecisionEvent& event) {
  v1::WatchPosteriorsResponse response;
  *response.mutable_decision() = event;
  Tell(scene, Serialize(response));
}

void WatchHub::OnEvidence(const priors::SceneKey& scene) {
  if (!WatchesDecisionsOf(scene)) return;
  if (loading_.contains(scene)) {
    changed_.insert(scene);
  } else {
    Load(scene);
  }
}

void WatchHub::Load(const priors::SceneKey& scene) {
  const bool submitted =
      context_.store.Submit([this, &loop = context_.loop, scene](priors::PriorStore& store) {
        loop.Post([this, scene, loaded = store.LoadScene(scene)] { OnLoaded(scene, loaded); });
      });
  // The queue is full; the next evidence tries again.
  if (submitted) loading_.insert(scene);
}

void WatchHub::OnLoaded(const priors::SceneKey& key,
                        const absl::StatusOr<std::optional<priors::SceneEvidence>>& scene) {
  loading_.erase(key);
  if (changed_.erase(key) > 0) Load(key);
  if (scene.ok() && scene->has_value()) Tell(key, Encode(**scene));
}

void WatchHub::Tell(const priors::SceneKey& scene, const grpc::ByteBuffer& event) {
  // This is a copy, because a watcher that ends removes itself.
  const std::set<PosteriorWatcher*> watchers = watchers_;
  for (PosteriorWatcher* watcher : watchers) {
    if (watcher->Watches(scene)) watcher->OnEvent(event);
  }
}

void WatchHub::OnImport() {
  const std::set<PosteriorWatcher*> watchers = watchers_;
  for (PosteriorWatcher* watcher : watchers) watcher->Resend();
}

void WatchHub::Drain() {
  draining_ = true;
  const std::set<PosteriorWatcher*> watchers = watchers_;
  for (PosteriorWatcher* watcher : watchers) {
    watcher->Close(absl::UnavailableError("the daemon is draining; watch again later"));
  }
}

grpc::ByteBuffer WatchHub::Encode(const priors::SceneEvidence& scene) const {
  v1::WatchPosteriorsResponse response;
  ToProto(scene, *response.mutable_posterior());
  response.mutable_posterior()->set_active_session_count(context_.sessions.ActiveCount(scene.key));
  return Serialize(response);
}

}  // namespace sweepstake::rpc
