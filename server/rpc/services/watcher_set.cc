#include "server/rpc/services/watcher_set.h"

#include <algorithm>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/posterior_watcher.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {

watch::WatchHub::Loop HubLoop(DecisionLoop& loop) {
  return {.post = [&loop](DecisionLoop::Task task) { loop.Post(std::move(task)); },
          .post_after =
              [&loop](int64_t delay_ns, DecisionLoop::Task task) {
                loop.PostAt(loop.clock().NowNs() + delay_ns, std::move(task));
              }};
}

absl::Status WatcherSet::Add(PosteriorWatcher& watcher) {
  if (draining_)
    return Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; watch again later");
  if (context_.counters.open_watcher_count >= context_.options.max_watchers) {
    return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                   "this daemon has as many watchers as it may; try again later");
  }
  watchers_.insert(&watcher);
  ++context_.counters.open_watcher_count;
  return absl::OkStatus();
}

void WatcherSet::Remove(PosteriorWatcher& watcher) {
  context_.counters.open_watcher_count -= watchers_.erase(&watcher);
}

bool WatcherSet::Watches(const priors::SceneKey& scene) const {
  return std::any_of(watchers_.begin(), watchers_.end(),
                     [&](const auto* watcher) { return watcher->Watches(scene); });
}

void WatcherSet::OnDecision(const priors::SceneKey& scene, const v1::DecisionEvent& event) {
  v1::WatchPosteriorsResponse response;
  *response.mutable_decision() = event;
  ToProto(context_.watch_hub.NextStamp(), *response.mutable_stamp());
  const grpc::ByteBuffer encoded = Serialize(response);
  ForEach([&](PosteriorWatcher& watcher) {
    if (watcher.Watches(scene)) watcher.OnDecision(encoded);
  });
}

void WatcherSet::OnPosterior(const priors::SceneEvidence& scene) {
  const grpc::ByteBuffer encoded = Encode(scene);
  ForEach([&](PosteriorWatcher& watcher) {
    if (watcher.Watches(scene.key)) watcher.OnPosterior(scene.key, encoded);
  });
}

void WatcherSet::OnReset() {
  ForEach([](PosteriorWatcher& watcher) { watcher.Resend(); });
}

void WatcherSet::Drain() {
  draining_ = true;
  ForEach([](PosteriorWatcher& watcher) {
    watcher.Close(Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; watch again later"));
  });
}

void WatcherSet::EndRefused() {
  ForEach([](PosteriorWatcher& watcher) { watcher.EndIfRefused(); });
}

grpc::ByteBuffer WatcherSet::Encode(const priors::SceneEvidence& scene) const {
  v1::WatchPosteriorsResponse response;
  ToProto(scene, *response.mutable_posterior());
  response.mutable_posterior()->set_active_session_count(context_.sessions.ActiveCount(scene.key));
  ToProto(context_.watch_hub.NextStamp(), *response.mutable_stamp());
  return Serialize(response);
}

}  // namespace sweepstake::rpc
