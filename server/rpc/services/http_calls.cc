#include "server/rpc/services/http_calls.h"

#include <map>
#include <utility>

#include "server/rpc/services/audit_service.h"
#include "server/rpc/services/page_stream.h"
#include "server/rpc/services/posteriors_service.h"
#include "server/rpc/services/priors_service.h"
#include "server/rpc/services/sessions_service.h"
#include "server/rpc/services/unary_call.h"

namespace sweepstake::rpc {
namespace {

using google::protobuf::Message;

// A response stream over HTTP. self_ keeps the object alive until Finish.
class HttpPages final : public PageSink, public std::enable_shared_from_this<HttpPages> {
 public:
  HttpPages(ServiceContext& context, HttpCall call) : context_(context), call_(std::move(call)) {}

  void Begin(Caller caller, LoadPage load) {
    self_ = shared_from_this();
    stream_ = std::make_shared<PageStream>(context_, std::move(caller), std::move(load), *this);
    context_.loop.Post([self = self_] { self->stream_->Begin(); });
  }

  void Write(const std::shared_ptr<const Message>& response) override {
    const std::shared_ptr<bool> taken(new bool(false), [self = self_](bool* value) {
      self->context_.loop.Post([self, ok = *value] { self->stream_->OnWritten(ok); });
      delete value;
    });
    if (!ended_) call_.on_response(response, taken);
  }
  void Finish(const absl::Status& status) override {
    Cancel(status);
    // The caller still uses the stream, so a later task releases it.
    context_.loop.Post([self = std::move(self_)] {});
  }
  void Cancel(const absl::Status& status) override {
    if (std::exchange(ended_, true)) return;
    CountError(status, context_.counters);
    call_.on_end(status);
  }

 private:
  ServiceContext& context_;
  const HttpCall call_;
  std::shared_ptr<HttpPages> self_;
  std::shared_ptr<PageStream> stream_;
  bool ended_ = false;
};

// Serves a call. The last argument is the authorized caller, or the error of the authorization.
using Handler = std::function<void(ServiceContext&, HttpCall, const absl::StatusOr<Caller>&)>;
struct ServedMethod {
  Rpc rpc;
  Handler handle;
};
using ServedMethods =
    std::map<const google::protobuf::Descriptor*, ServedMethod>;  // by type of the request

void End(ServiceContext& context, const HttpCall& call, const absl::Status& status) {
  CountError(status, context.counters);
  call.on_end(status);
}

template <typename Request, typename Response>
ServedMethods::value_type Unary(Rpc rpc) {
  const auto handle = [](ServiceContext& context, HttpCall call,
                         const absl::StatusOr<Caller>& caller) {
    if (!caller.ok()) return End(context, call, caller.status());
    const auto& request = static_cast<const Request&>(*call.request);
    const auto response = std::make_shared<Response>();
    Answer(context, *caller, request, *response,
           [&context, response, call = std::move(call)](const absl::Status& status) {
             context.access.refusals().TellEnd(call.peer, status);
             if (status.ok()) call.on_response(response, nullptr);
             End(context, call, status);
           });
  };
  return {Request::descriptor(), {rpc, handle}};
}

template <typename Request>
ServedMethods::value_type Pages(Rpc rpc) {
  const auto handle = [](ServiceContext& context, HttpCall call,
                         const absl::StatusOr<Caller>& caller) {
    auto load = PagesFor(context, caller, static_cast<const Request&>(*call.request));
    if (!load.ok()) return End(context, call, load.status());
    std::make_shared<HttpPages>(context, std::move(call))->Begin(*caller, *std::move(load));
  };
  return {Request::descriptor(), {rpc, handle}};
}

const ServedMethods& AllMethods() {
  static const auto& methods = *new ServedMethods{
      Unary<v1::ListPosteriorsRequest, v1::ListPosteriorsResponse>(
          RpcOf("PosteriorsService/ListPosteriors")),
      Unary<v1::GetPosteriorRequest, v1::GetPosteriorResponse>(
          RpcOf("PosteriorsService/GetPosterior")),
      Unary<v1::ListSessionsRequest, v1::ListSessionsResponse>(
          RpcOf("SessionsService/ListSessions")),
      Unary<v1::KickSessionRequest, v1::KickSessionResponse>(RpcOf("SessionsService/KickSession")),
      Unary<v1::OrderSessionRequest, v1::OrderSessionResponse>(
          RpcOf("SessionsService/OrderSession")),
      Unary<v1::RevokePriorsRequest, v1::RevokePriorsResponse>(RpcOf("PriorsService/RevokePriors")),
      Unary<v1::PromotePriorsRequest, v1::PromotePriorsResponse>(
          RpcOf("PriorsService/PromotePriors")),
      Pages<v1::ExportPriorsRequest>(RpcOf("PriorsService/ExportPriors")),
      Pages<v1::CompareBuildsRequest>(RpcOf("PriorsService/CompareBuilds")),
      Pages<v1::ListAuditSegmentsRequest>(RpcOf("AuditService/ListAuditSegments")),
      Pages<v1::ExportDecisionsRequest>(RpcOf("AuditService/ExportDecisions"))};
  return methods;
}

}  // namespace

bool BeginHttpCall(ServiceContext& context, HttpCall call) {
  const auto method = AllMethods().find(call.request->GetDescriptor());
  if (method == AllMethods().end()) return false;
  const auto caller = context.access.AuthorizeOverHttp(call.peer, call.token, method->second.rpc);
  method->second.handle(context, std::move(call), caller);
  return true;
}

}  // namespace sweepstake::rpc
