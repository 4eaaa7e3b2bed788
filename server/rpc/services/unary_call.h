// Serves a call with one answer: checks the caller first, and sends every error to the client with
// its reason. Refusals are logged.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Ends the call. Called once, on any thread; the response must be complete by then.
using EndCall = std::function<void(const absl::Status&)>;

// Serves the call with `handle(caller, end)` if the caller may make it. Neither function may block.
template <typename Handle>
grpc::ServerUnaryReactor* ServeUnary(ServiceContext& context, grpc::CallbackServerContext& call,
                                     Rpc rpc, Handle handle) {
  grpc::ServerUnaryReactor* reactor = call.DefaultReactor();
  if (auto caller = context.access.Authorize(call, rpc); caller.ok()) {
    handle(*std::move(caller),
           [reactor, &context, peer = CallerOf(call)](const absl::Status& status) {
             context.access.refusals().TellEnd(peer, status);
             reactor->Finish(ToGrpc(status, context.counters));
           });
  } else {
    reactor->Finish(ToGrpc(caller.status(), context.counters));
  }
  return reactor;
}

}  // namespace sweepstake::rpc
