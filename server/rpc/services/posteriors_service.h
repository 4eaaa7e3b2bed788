// sweepstake.v1.PosteriorsService: lists the store's scenes and streams changes. Thread-safe.
//
// A page token contains the last scene of its page. A token of another form is INVALID_ARGUMENT.
#pragma once

#include "server/rpc/services/unary_call.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListPosteriorsRequest& request,
            v1::ListPosteriorsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::GetPosteriorRequest& request,
            v1::GetPosteriorResponse& response, const EndCall& end);

class PosteriorsService final
    : public v1::PosteriorsService::WithCallbackMethod_ListPosteriors<
          v1::PosteriorsService::WithCallbackMethod_GetPosterior<
              v1::PosteriorsService::WithRawCallbackMethod_WatchPosteriors<
                  v1::PosteriorsService::Service>>> {
 public:
  explicit PosteriorsService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* ListPosteriors(grpc::CallbackServerContext* call,
                                           const v1::ListPosteriorsRequest* request,
                                           v1::ListPosteriorsResponse* response) override {
    return ServeUnary(context_, *call, RpcOf("PosteriorsService/ListPosteriors"), *request,
                      *response);
  }
  grpc::ServerUnaryReactor* GetPosterior(grpc::CallbackServerContext* call,
                                         const v1::GetPosteriorRequest* request,
                                         v1::GetPosteriorResponse* response) override {
    return ServeUnary(context_, *call, RpcOf("PosteriorsService/GetPosterior"), *request,
                      *response);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchPosteriors(
      grpc::CallbackServerContext* call, const grpc::ByteBuffer* request) override;

 private:
  ServiceContext& context_;
};

}  // namespace sweepstake::rpc
