// The stream of one watcher: first the current state of the matching scenes, then events. Each
// event is encoded once for all watchers.
//
// A watcher that reads slowly costs the memory of a page of scenes and a few events. At the bound
// the events are dropped, and once it has read the current message it gets all scenes again. A
// watcher that does not read at all is disconnected. It is used on the decision loop;
// gRPC's callbacks run elsewhere and only post to the loop. It owns itself from Start until gRPC is
// done with it.
#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <memory>
#include <optional>

#include "server/priors/prior_store.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

class PosteriorWatcher final : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                               public std::enable_shared_from_this<PosteriorWatcher> {
 public:
  static PosteriorWatcher* Start(ServiceContext& context, grpc::CallbackServerContext& call,
                                 grpc::ByteBuffer request);

  bool Watches(const priors::SceneKey& scene) const;
  void OnEvent(const grpc::ByteBuffer& event);
  // Sends all scenes again, since what was sent is out of date.
  void Resend();
  void Close(const absl::Status& status);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  PosteriorWatcher(ServiceContext& context, grpc::CallbackServerContext& call)
      : context_(context), call_(call) {}

  void Begin(grpc::ByteBuffer request);
  void LoadPage();
  void OnPage(const absl::StatusOr<std::vector<priors::SceneEvidence>>& page);
  void WriteNext();
  std::optional<grpc::ByteBuffer> TakeNext();
  void OnWritten(bool ok);
  void GuardWrite();

  ServiceContext& context_;
  grpc::CallbackServerContext& call_;
  std::shared_ptr<PosteriorWatcher> self_;  // until OnDone

  priors::SceneFilter filter_;
  std::deque<grpc::ByteBuffer> scenes_;           // the rest of the current page
  std::optional<priors::SceneKey> last_of_page_;  // the next page begins after it
  std::deque<grpc::ByteBuffer> events_;           // at most kWatcherQueueEvents
  bool loading_ = false;                          // the store is reading a page
  bool page_wanted_ = false;                      // another page follows this one
  bool stale_ = false;                            // all scenes must be sent again
  grpc::ByteBuffer write_bytes_;
  bool writing_ = false;
  uint64_t write_count_ = 0;
  std::optional<absl::Status> end_;
  bool finished_ = false;
};

}  // namespace sweepstake::rpc
