// The stream of one who watches posteriors: first the current state of the matching scenes, then
// events, which are encoded once for all watchers.
//
// A watcher that reads slowly gets each scene that has changed once, as it is by then, and misses
// decisions: at kWatcherQueueBytes those that wait are dropped.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/rpc/services/watcher.h"

namespace sweepstake::rpc {

class PosteriorWatcher final : public Watcher {
 public:
  PosteriorWatcher(ServiceContext& context, grpc::CallbackServerContext& call,
                   auth::Principal caller)
      : Watcher(context, call, std::move(caller)) {}

  // `event` has decisions of one moment and scene.
  void OnDecisions(const grpc::ByteBuffer& event);
  void OnPosterior(const priors::SceneKey& scene, const grpc::ByteBuffer& event);
  // Sends all scenes again, since what was sent is out of date.
  void Resend();

 private:
  // Decisions or, without bytes, the place of a scene in posteriors_.
  struct Event {
    std::optional<grpc::ByteBuffer> decisions;
    priors::SceneKey scene;
  };

  struct Posterior {
    grpc::ByteBuffer event;
    uint64_t page = 0;  // how many pages had been asked for
  };

  absl::Status Join() override;
  void Leave() override;
  std::optional<grpc::ByteBuffer> TakeNext() override;
  void Forget() override;

  std::optional<grpc::ByteBuffer> TakeEvent();
  void LoadPage();
  void OnPage(const absl::StatusOr<std::vector<v1::ScenePosterior>>& page);

  std::deque<grpc::ByteBuffer> scenes_;               // the rest of the current page
  std::optional<priors::SceneKey> last_of_page_;      // the next page begins after it
  std::deque<Event> events_;                          // in the order in which they happened
  size_t decision_bytes_ = 0;                         // of the decisions in events_
  std::map<priors::SceneKey, Posterior> posteriors_;  // the latest of each scene in events_
  uint64_t page_count_ = 0;                           // pages that the store was asked for
  bool loading_ = false;                              // the store is reading a page
  bool page_wanted_ = false;                          // another page follows this one
  bool stale_ = true;                                 // all scenes must be sent
};

}  // namespace sweepstake::rpc
