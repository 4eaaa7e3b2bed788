// sweepstake.v1.SessionsService: shows and ends the sessions in memory. Thread-safe.
#pragma once

#include <set>

#include "server/rpc/services/service_context.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::rpc {

class SessionWatcher;

class AdminLog;

class SessionsService final : public v1::SessionsService::WithCallbackMethod_ListSessions<
                                  v1::SessionsService::WithCallbackMethod_WatchSessions<
                                      v1::SessionsService::WithCallbackMethod_KickSession<
                                          v1::SessionsService::WithCallbackMethod_OrderSession<
                                              v1::SessionsService::Service>>>>,
                              public watch::SessionListener {
 public:
  SessionsService(ServiceContext& context, AdminLog& admin) : context_(context), admin_(admin) {}

  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* call,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchSessionsResponse>* WatchSessions(
      grpc::CallbackServerContext* call, const v1::WatchSessionsRequest* request) override;
  grpc::ServerUnaryReactor* KickSession(grpc::CallbackServerContext* call,
                                        const v1::KickSessionRequest* request,
                                        v1::KickSessionResponse* response) override;
  grpc::ServerUnaryReactor* OrderSession(grpc::CallbackServerContext* call,
                                         const v1::OrderSessionRequest* request,
                                         v1::OrderSessionResponse* response) override;

  // The rest is called on the loop.
  bool WatchesSessions() const override { return !watchers_.empty(); }
  void OnSessions(const watch::SessionChanges& changes) override;
  // Errors: those of WatcherSet::Add.
  absl::Status Add(SessionWatcher& watcher);
  void Remove(SessionWatcher& watcher);
  void Drain();
  // Ends the streams of callers whose tokens are not valid any more.
  void EndRefused();

 private:
  ServiceContext& context_;
  AdminLog& admin_;
  std::set<SessionWatcher*> watchers_;
  bool draining_ = false;
};

}  // namespace sweepstake::rpc
