// Serves calls that arrive over HTTP. They go through the same checks, limits and handlers as calls
// over gRPC. The handlers are called directly, without a gRPC connection.
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
  // Called with each response. A stream continues when the last copy of `taken` is destroyed:
  // - with the value true (the client has taken this response), the next response follows;
  // - with the value false, the stream ends.
  // For a call with one response, `taken` is null.
  std::function<void(const std::shared_ptr<const google::protobuf::Message>&,
                     std::shared_ptr<bool> taken)>
      on_response;
  // Called once, after the last response. on_response and on_end are called on any thread, and must
  // not block.
  std::function<void(const absl::Status&)> on_end;
};

// Begins the call. Returns false for methods with several requests (StreamTelemetry,
// ImportPriors) and for methods without a finite answer (Watch methods). Any thread may call
// it.
bool BeginHttpCall(ServiceContext& context, HttpCall call);

}  // namespace sweepstake::rpc
