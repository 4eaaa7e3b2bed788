// The stream of one watcher: first the current state of the matching scenes, then events. Each
// event is encoded once for all watchers.
//
// A watcher that reads slowly gets each scene that has changed once, as it is by then, and misses
// decisions: at kWatcherQueueBytes those that wait are dropped. A watcher that does not read at all
// is disconnected. It is used on the decision loop;
// gRPC's callbacks run elsewhere and only post to the loop. It owns itself from Start until gRPC is
// done with it.
#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "server/priors/prior_store.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"

namespace sweepstake::rpc {

class PosteriorWatcher final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                               public StallingCall,
                               public std::enable_shared_from_this<PosteriorWatcher> {
 public:
  static PosteriorWatcher* Start(ServiceContext& context, grpc::CallbackServerContext& call,
                                 grpc::ByteBuffer request, auth::Principal caller);

  bool Watches(const priors::SceneKey& scene) const;
  void OnDecision(const grpc::ByteBuffer& event);
  void OnPosterior(const priors::SceneKey& scene, const grpc::ByteBuffer& event);
  // Sends all scenes again, since what was sent is out of date.
  void Resend();
  // Closes the stream if the caller's token is not valid any more.
  void EndIfRefused();
  void Close(const absl::Status& status);
  int64_t waiting_since_ns() const override { return writing_ ? write_start_ns_ : Clock::kNever; }
  void OnStalled() override;

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  // A decision or, without bytes, the place of a scene in posteriors_.
  struct Event {
    std::optional<grpc::ByteBuffer> decision;
    priors::SceneKey scene;
  };

  PosteriorWatcher(ServiceContext& context, grpc::CallbackServerContext& call,
                   auth::Principal caller)
      : context_(context), call_(call), caller_(std::move(caller)) {}

  void Begin(grpc::ByteBuffer request);
  void LoadPage();
  void OnPage(const absl::StatusOr<std::vector<priors::SceneEvidence>>& page);
  void WriteNext();
  std::optional<grpc::ByteBuffer> TakeNext();
  std::optional<grpc::ByteBuffer> TakeEvent();
  void OnWritten(bool ok);

  ServiceContext& context_;
  grpc::CallbackServerContext& call_;
  const auth::Principal caller_;
  std::shared_ptr<PosteriorWatcher> self_;  // keeps this object alive until OnDone

  priors::SceneFilter filter_;
  std::deque<grpc::ByteBuffer> scenes_;                      // the rest of the current page
  std::optional<priors::SceneKey> last_of_page_;             // the next page begins after it
  std::deque<Event> events_;                                 // in the order in which they happened
  size_t decision_bytes_ = 0;                                // of the decisions in events_
  std::map<priors::SceneKey, grpc::ByteBuffer> posteriors_;  // the latest of each scene in events_
  bool loading_ = false;                                     // the store is reading a page
  bool page_wanted_ = false;                                 // another page follows this one
  bool stale_ = false;                                       // all scenes must be sent again
  grpc::ByteBuffer write_bytes_;
  bool writing_ = false;
  int64_t write_start_ns_ = 0;
  std::optional<absl::Status> end_;
  bool finished_ = false;
};

}  // namespace sweepstake::rpc
