// Calls of the services' methods that come over HTTP: the same checks, limits and handlers as over
// gRPC, without a connection in between.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

struct HttpCall {
  std::shared_ptr<const google::protobuf::Message> request;
  std::string peer;                  // the remote address in gRPC's format
  std::optional<std::string> token;  // the client's token
  // Called with each response. Of a stream, the next one follows when the client has taken this
  // one: when the last copy of `taken` is destroyed with the value true. With the value false the
  // stream ends. One answer has no `taken`.
  using Taken = std::shared_ptr<bool>;
  std::function<void(const std::shared_ptr<const google::protobuf::Message>&, Taken)> on_response;
  // Called last, and once. These two are called on any thread, and must not block.
  std::function<void(const absl::Status&)> on_end;
};

// Begins the call. Returns false if the request is not one of a method with one request and a
// finite answer. Any thread may call it.
bool BeginHttpCall(ServiceContext& context, HttpCall call);

}  // namespace sweepstake::rpc
