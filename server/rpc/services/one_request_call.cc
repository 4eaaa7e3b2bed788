#include "server/rpc/services/one_request_call.h"

#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/stall_sweep.h"

namespace sweepstake::rpc {

OneRequestCall::OneRequestCall(ServiceContext& context, const ServedMethod& method,
                               grpc::CallbackServerContext& call, Caller caller)
    : context_(context), method_(method), call_(call), caller_(std::move(caller)) {
  StartRead(&request_);
}

void OneRequestCall::OnReadDone(bool ok) {
  const std::shared_ptr<google::protobuf::Message> request(method_.request->New());
  if (!ok && call_.IsCancelled()) return End(absl::CancelledError("the client has left"));
  if (!ok || !Parse(request_, *request)) {
    const absl::Status status =
        Refused(v1::ERROR_REASON_MALFORMED_MESSAGE, "the request does not parse");
    context_.access.refusals().TellEnd(caller_.peer, status);
    return End(status);
  }
  ServedCall call = {.request = request,
                     .peer = caller_.peer,
                     .on_response = [this](const auto& response,
                                           auto taken) { Write(*response, std::move(taken)); },
                     .on_end = [this](const absl::Status& status) { End(status); }};
  method_.serve(context_, std::move(call), caller_);
}

void OneRequestCall::Write(const google::protobuf::Message& response, std::shared_ptr<bool> taken) {
  response_ = Serialize(response);
  taken_ = std::move(taken);
  {
    const std::lock_guard lock(mutex_);
    has_last_ = taken_ == nullptr;
    if (has_last_) return;
    is_writing_ = true;
  }
  StartWrite(&response_);
}

void OneRequestCall::OnWriteDone(bool ok) {
  // Destroying the last copy continues the stream, which may start the next write.
  const std::shared_ptr<bool> taken = std::exchange(taken_, nullptr);
  *taken = ok;
  std::optional<grpc::Status> end;
  {
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    end = end_;
  }
  if (end) Finish(*end);
}

// A stream that ends during a write is cut off, because its client does not read.
void OneRequestCall::End(const absl::Status& status) {
  const grpc::Status end = ToGrpc(status, context_.counters);
  bool has_last = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_writing_) end_ = end;
    has_last = has_last_;
    if (end_) return Cancel(call_, end);
  }
  has_last ? StartWriteAndFinish(&response_, {}, end) : Finish(end);
}

}  // namespace sweepstake::rpc
