// The stream of one who watches sessions: first the matching ones as they are, then those that
// change.
//
// It keeps only which sessions the client is to hear of, and reads what they are when it writes. A
// client that reads slowly thus gets each session once, as it is by then, and the memory is bounded
// by the number of sessions. One that does not read at all is disconnected. It is used on the
// decision loop; gRPC's callbacks run elsewhere and only post to the loop. It owns itself from
// Start until gRPC is done with it.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>

#include "server/priors/prior_store.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::rpc {

class SessionsService;

class SessionWatcher final : public grpc::ServerWriteReactor<v1::WatchSessionsResponse>,
                             public StallingCall {
 public:
  static SessionWatcher* Start(ServiceContext& context, SessionsService& service,
                               grpc::CallbackServerContext& call, priors::SceneFilter filter,
                               auth::Principal caller);

  void OnSessions(const watch::SessionChanges& changes);
  // Closes the stream if the caller's token is not valid any more.
  void EndIfRefused();
  void Close(const absl::Status& status);
  int64_t waiting_since_ns() const override { return writing_ ? write_start_ns_ : Clock::kNever; }
  void OnStalled() override;

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  SessionWatcher(ServiceContext& context, SessionsService& service,
                 grpc::CallbackServerContext& call, priors::SceneFilter filter,
                 auth::Principal caller);

  void Begin();
  void WriteNext();
  // Fills in the next event. Returns false if there is none.
  bool TakeNext();
  void OnWritten(bool ok);

  ServiceContext& context_;
  SessionsService& service_;
  grpc::CallbackServerContext& call_;
  const priors::SceneFilter filter_;
  const auth::Principal caller_;
  watch::SessionChanges changes_;  // that wait
  v1::WatchSessionsResponse response_;
  bool writing_ = false;
  int64_t write_start_ns_ = 0;
  std::optional<absl::Status> end_;
  bool finished_ = false;
};

}  // namespace sweepstake::rpc
