// Serves a call with one answer: checks the caller first, and sends every error to the client with
// its reason. Refusals are logged.
//
// Each method with one answer has a function
//   void Answer(ServiceContext&, const Caller&, const Request&, Response&, const EndCall&)
// which must not block. Request and response live until the call has ended.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Ends the call. Called once, on any thread. The response must be complete before this call.
using EndCall = std::function<void(const absl::Status&)>;

// The status of a call whose job the store has refused, because its queue is full.
inline absl::Status StoreBusy() {
  return Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store is overloaded; try again later");
}

template <typename Request, typename Response>
grpc::ServerUnaryReactor* ServeUnary(ServiceContext& context, grpc::CallbackServerContext& call,
                                     Rpc rpc, const Request& request, Response& response) {
  grpc::ServerUnaryReactor* reactor = call.DefaultReactor();
  if (const auto caller = context.access.Authorize(call, rpc); caller.ok()) {
    Answer(context, *caller, request, response,
           [reactor, &context, peer = caller->peer](const absl::Status& status) {
             context.access.refusals().TellEnd(peer, status);
             reactor->Finish(ToGrpc(status, context.counters));
           });
  } else {
    reactor->Finish(ToGrpc(caller.status(), context.counters));
  }
  return reactor;
}

// A streaming call that is refused at once.
template <typename Reactor>
class RefusedCall final : public Reactor {
 public:
  RefusedCall(ServiceContext& context, const absl::Status& status) {
    this->Finish(ToGrpc(status, context.counters));
  }
  void OnDone() override { delete this; }
};

}  // namespace sweepstake::rpc
