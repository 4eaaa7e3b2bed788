// sweepstake.v1.SessionsService: shows, orders and ends the sessions in memory. Thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/rpc/services/watcher.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::sessions {
class AdminLog;
}

namespace sweepstake::rpc {

class BoxWatcher;
class SessionWatcher;
struct SessionTick;

class SessionsService final : public v1::SessionsService::WithCallbackMethod_ListSessions<
                                  v1::SessionsService::WithRawCallbackMethod_WatchSessions<
                                      v1::SessionsService::WithCallbackMethod_KickSession<
                                          v1::SessionsService::WithCallbackMethod_OrderSession<
                                              v1::SessionsService::WithRawCallbackMethod_WatchBoxes<
                                                  v1::SessionsService::Service>>>>>,
                              public watch::SessionListener {
 public:
  SessionsService(ServiceContext& context, sessions::AdminLog& admin)
      : context_(context), admin_(admin), watchers_(context), box_watchers_(context) {}

  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* call,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchSessions(
      grpc::CallbackServerContext* call, const grpc::ByteBuffer* request) override;
  grpc::ServerUnaryReactor* KickSession(grpc::CallbackServerContext* call,
                                        const v1::KickSessionRequest* request,
                                        v1::KickSessionResponse* response) override;
  grpc::ServerUnaryReactor* OrderSession(grpc::CallbackServerContext* call,
                                         const v1::OrderSessionRequest* request,
                                         v1::OrderSessionResponse* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchBoxes(grpc::CallbackServerContext* call,
                                                         const grpc::ByteBuffer* request) override;

  // The rest is called on the loop.
  bool WatchesSessions() const override { return !watchers_.empty(); }
  void OnSessions(const watch::SessionChanges& changes) override;
  WatcherGroup<SessionWatcher>& watchers() { return watchers_; }
  WatcherGroup<BoxWatcher>& box_watchers() { return box_watchers_; }
  // Takes changes that one message can tell, and returns the message; absent if there are none.
  std::optional<grpc::ByteBuffer> TakeMessage(watch::SessionChanges& changes) const;

 private:
  // Returns the session, if it is in memory and has not ended. Of another project's session the
  // answer tells a caller nothing: null.
  std::shared_ptr<sessions::GameSession> FindFor(const auth::Principal& caller,
                                                 const std::string& session_id) const;
  // Returns what watchers of this filter are told.
  std::shared_ptr<const SessionTick> Encode(const priors::SceneFilter& filter,
                                            const watch::SessionChanges& changes) const;

  ServiceContext& context_;
  sessions::AdminLog& admin_;
  WatcherGroup<SessionWatcher> watchers_;
  WatcherGroup<BoxWatcher> box_watchers_;
};

}  // namespace sweepstake::rpc
