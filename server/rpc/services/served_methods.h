// The methods with one request and a finite answer, which gRPC and HTTP serve alike: one row per
// method in served_methods.cc. Two kinds of functions implement them, for every Request:
//   void Answer(ServiceContext&, const Caller&, const Request&, Response&, const EndCall&)
//   absl::StatusOr<LoadPage> PagesOf(const Caller&, const Request&)
// Answer gives one response and must not block. PagesOf begins a stream of responses; its errors
// refuse the call.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// A call whose request was read.
struct ServedCall {
  std::shared_ptr<const google::protobuf::Message> request;
  std::string peer;  // the remote address in gRPC's format
  // Called with each response. A stream continues when the last copy of `taken` is destroyed:
  // - with the value true (the client has taken this response), the next response follows;
  // - with the value false, the stream ends.
  // For a call with one response, `taken` is null.
  std::function<void(const std::shared_ptr<const google::protobuf::Message>&,
                     std::shared_ptr<bool> taken)>
      on_response;
  // Called once, after the last response, or earlier to end a stream whose client does not read.
  // Both functions are called on any thread, and must not block.
  std::function<void(const absl::Status&)> on_end;
};

struct ServedMethod {
  Rpc rpc;
  const google::protobuf::Message* request;  // an empty request
  void (*serve)(ServiceContext& context, ServedCall call, const Caller& caller);
};

// Returns the row of a method, such as "PosteriorsService/ListPosteriors", or of the method with
// this type of request. Returns null for methods with several requests (StreamTelemetry,
// ImportPriors), for Watch methods and for unknown ones.
const ServedMethod* FindMethod(std::string_view name);
const ServedMethod* FindMethod(const google::protobuf::Descriptor* request);

// Checks the caller of a call over HTTP and begins the call. Returns false if FindMethod finds no
// row. Any thread may call it.
bool BeginHttpCall(ServiceContext& context, ServedCall call,
                   const std::optional<std::string>& token);

}  // namespace sweepstake::rpc
