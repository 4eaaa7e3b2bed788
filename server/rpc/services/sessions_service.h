// sweepstake.v1.SessionsService: lists, watches and ends the sessions in memory, and gives orders
// to their games. Thread-safe.
#pragma once

#include "server/rpc/services/unary_call.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListSessionsRequest& request,
            v1::ListSessionsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::KickSessionRequest& request,
            v1::KickSessionResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::OrderSessionRequest& request,
            v1::OrderSessionResponse& response, const EndCall& end);

class SessionsService final : public v1::SessionsService::WithCallbackMethod_ListSessions<
                                  v1::SessionsService::WithRawCallbackMethod_WatchSessions<
                                      v1::SessionsService::WithCallbackMethod_KickSession<
                                          v1::SessionsService::WithCallbackMethod_OrderSession<
                                              v1::SessionsService::WithRawCallbackMethod_WatchBoxes<
                                                  v1::SessionsService::Service>>>>> {
 public:
  explicit SessionsService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* call,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override {
    return ServeUnary(context_, *call, RpcOf("SessionsService/ListSessions"), *request, *response);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchSessions(
      grpc::CallbackServerContext* call, const grpc::ByteBuffer* request) override;
  grpc::ServerUnaryReactor* KickSession(grpc::CallbackServerContext* call,
                                        const v1::KickSessionRequest* request,
                                        v1::KickSessionResponse* response) override {
    return ServeUnary(context_, *call, RpcOf("SessionsService/KickSession"), *request, *response);
  }
  grpc::ServerUnaryReactor* OrderSession(grpc::CallbackServerContext* call,
                                         const v1::OrderSessionRequest* request,
                                         v1::OrderSessionResponse* response) override {
    return ServeUnary(context_, *call, RpcOf("SessionsService/OrderSession"), *request, *response);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchBoxes(grpc::CallbackServerContext* call,
                                                         const grpc::ByteBuffer* request) override;

 private:
  ServiceContext& context_;
};

}  // namespace sweepstake::rpc
