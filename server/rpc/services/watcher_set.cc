#include "server/rpc/services/watcher_set.h"

#include <utility>

#include "server/rpc/services/posterior_watcher.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {

watch::WatchHub::Loop HubLoop(sessions::DecisionLoop& loop) {
  // The sums of a scene must not overtake the news of the commits that they have.
  return {.post = [&loop](sessions::DecisionLoop::Task task) { loop.PostLater(std::move(task)); },
          .post_after =
              [&loop](int64_t delay_ns, sessions::DecisionLoop::Task task) {
                loop.PostAt(loop.clock().NowNs() + delay_ns, std::move(task));
              }};
}

bool WatcherSet::Watches(const priors::SceneKey& scene) { return !group_.Of(scene).empty(); }

void WatcherSet::OnDecision(const sessions::DecisionEvent& event) {
  const priors::SceneKey& scene = event.session.scene;
  v1::WatchPosteriorsResponse& waiting = decisions_[scene];
  ToProto(event, *waiting.add_decisions());
  if (waiting.decisions_size() < kDecisionsPerMessage) return;
  TellDecisions(scene, waiting);
  decisions_.erase(scene);
}

void WatcherSet::OnTick() {
  for (auto& [scene, waiting] : decisions_) TellDecisions(scene, waiting);
  decisions_.clear();
}

void WatcherSet::TellDecisions(const priors::SceneKey& scene,
                               v1::WatchPosteriorsResponse& waiting) {
  ToProto(context_.watch_hub.NextStamp(), *waiting.mutable_stamp());
  const grpc::ByteBuffer encoded = Serialize(waiting);
  // One that ends meanwhile leaves the group.
  const std::vector<PosteriorWatcher*> told = group_.Of(scene);
  for (PosteriorWatcher* watcher : told) watcher->OnDecisions(encoded);
}

void WatcherSet::OnPosterior(const priors::SceneEvidence& scene) {
  v1::ScenePosterior posterior;
  ToProto(scene, posterior);
  const grpc::ByteBuffer encoded = Encode(std::move(posterior));
  const std::vector<PosteriorWatcher*> told = group_.Of(scene.key);
  for (PosteriorWatcher* watcher : told) watcher->OnPosterior(scene.key, encoded);
}

void WatcherSet::OnReset() {
  group_.ForEach([](PosteriorWatcher& watcher) { watcher.Resend(); });
}

grpc::ByteBuffer WatcherSet::Encode(v1::ScenePosterior scene) const {
  scene.set_active_session_count(context_.sessions.ActiveCount(FromProto(scene)));
  v1::WatchPosteriorsResponse response;
  *response.mutable_posterior() = std::move(scene);
  ToProto(context_.watch_hub.NextStamp(), *response.mutable_stamp());
  return Serialize(response);
}

grpc::ByteBuffer WatcherSet::EncodeMark() const {
  v1::WatchPosteriorsResponse response;
  response.set_all_told(true);
  ToProto(context_.watch_hub.NextStamp(), *response.mutable_stamp());
  return Serialize(response);
}

}  // namespace sweepstake::rpc
