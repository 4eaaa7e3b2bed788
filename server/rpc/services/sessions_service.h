// sweepstake.v1.SessionsService: shows, orders and ends the sessions in memory. Thread-safe.
#pragma once

#include <memory>
#include <string>

#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::sessions {
class AdminLog;
}

namespace sweepstake::rpc {

class SessionsService final : public v1::SessionsService::WithCallbackMethod_ListSessions<
                                  v1::SessionsService::WithRawCallbackMethod_WatchSessions<
                                      v1::SessionsService::WithCallbackMethod_KickSession<
                                          v1::SessionsService::WithCallbackMethod_OrderSession<
                                              v1::SessionsService::WithRawCallbackMethod_WatchBoxes<
                                                  v1::SessionsService::Service>>>>> {
 public:
  SessionsService(ServiceContext& context, sessions::AdminLog& admin)
      : context_(context), admin_(admin) {}

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

 private:
  // Returns the session if it is in memory and has not ended. For a session of a project that the
  // caller may not use, the answer is null too, so that it reveals nothing.
  std::shared_ptr<sessions::GameSession> FindFor(const auth::Principal& caller,
                                                 const std::string& session_id) const;

  ServiceContext& context_;
  sessions::AdminLog& admin_;
};

}  // namespace sweepstake::rpc
