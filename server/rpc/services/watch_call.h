// Connects watchers to the event bus. For gRPC calls the sink is in watch_call.cc. The HTTP server
// passes its own sink to BeginWatch.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/events/event_bus.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Converts the request of a Watch method to a Wish; absent for a request of another method.
std::optional<events::Wish> WishOf(const google::protobuf::Message& request);

// Returns the Watch method that streams events of this kind.
Rpc RpcOf(events::Kind kind);
// Inverts RpcOf. Returns nothing for other methods.
std::optional<events::Kind> WatchedBy(std::string_view method);

// Begins to watch for an authorized caller. Called on the loop. Errors go to Sink::OnEnd, some of
// them before BeginWatch returns:
// - PERMISSION_DENIED (the token is not valid for the project),
// - RESOURCE_EXHAUSTED (too many watchers; see AccessControl::BeginWatch),
// - those of EventBus::Subscribe,
// - the error of CheckStill, when the caller's token was revoked or has expired.
void BeginWatch(ServiceContext& context, events::Wish wish, const Caller& caller,
                events::Sink& sink);

// Serves a call that watches. A client that does not read for RpcOptions::watcher_patience_ns is
// disconnected.
grpc::ServerGenericBidiReactor* ServeWatch(ServiceContext& context,
                                           grpc::CallbackServerContext& call, events::Kind kind,
                                           Caller caller);

}  // namespace sweepstake::rpc
