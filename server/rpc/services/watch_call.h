// Connects watchers to the bus of events: calls of gRPC here, and those of the HTTP server, which
// brings its own sink.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/grpcpp.h>

#include <optional>
#include <string>
#include <utility>

#include "server/events/event_bus.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Returns what the request wants to watch; absent if it is not a request of a Watch method.
std::optional<events::Wish> WishOf(const google::protobuf::Message& request);

// Returns the Watch method of the kind.
Rpc RpcOf(events::Kind kind);

// Begins to watch for an authorized caller. The errors that end the watch go to the sink;
// PERMISSION_DENIED (the project), RESOURCE_EXHAUSTED (as AccessControl::BeginWatch), and those of
// EventBus::Subscribe are possible at once. Called on the loop.
void BeginWatch(ServiceContext& context, events::Wish wish, const Caller& caller,
                events::Sink& sink);

// Serves a call that watches. A client that does not read for RpcOptions::watcher_patience_ns is
// disconnected. `parsed` says whether its request is valid.
grpc::ServerWriteReactor<grpc::ByteBuffer>* ServeWatch(ServiceContext& context,
                                                       grpc::CallbackServerContext& call,
                                                       events::Wish wish, bool parsed);

template <typename Request>
grpc::ServerWriteReactor<grpc::ByteBuffer>* ServeWatch(ServiceContext& context,
                                                       grpc::CallbackServerContext& call,
                                                       grpc::ByteBuffer bytes) {
  Request request;
  const bool parsed = Parse(bytes, request);
  return ServeWatch(context, call, WishOf(request).value(), parsed);
}

}  // namespace sweepstake::rpc
