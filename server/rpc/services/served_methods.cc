#include "server/rpc/services/served_methods.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/rpc/services/alerts_service.h"
#include "server/rpc/services/audit_service.h"
#include "server/rpc/services/history_service.h"
#include "server/rpc/services/page_stream.h"
#include "server/rpc/services/posteriors_service.h"
#include "server/rpc/services/priors_service.h"
#include "server/rpc/services/sessions_service.h"

namespace sweepstake::rpc {
namespace {

using google::protobuf::Message;

// A stream of responses. self_ keeps the object alive until Finish.
class Pages final : public PageSink, public std::enable_shared_from_this<Pages> {
 public:
  Pages(ServiceContext& context, ServedCall call) : context_(context), call_(std::move(call)) {}

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
    if (!std::exchange(ended_, true)) call_.on_end(status);
  }

 private:
  ServiceContext& context_;
  const ServedCall call_;
  std::shared_ptr<Pages> self_;
  std::shared_ptr<PageStream> stream_;
  bool ended_ = false;
};

template <typename Request, typename Response>
ServedMethod Unary(Rpc rpc) {
  const auto serve = [](ServiceContext& context, ServedCall call, const Caller& caller) {
    const auto& request = static_cast<const Request&>(*call.request);
    const auto response = std::make_shared<Response>();
    Answer(context, caller, request, *response,
           [&context, response, call = std::move(call)](const absl::Status& status) {
             context.access.refusals().TellEnd(call.peer, status);
             if (status.ok()) call.on_response(response, nullptr);
             call.on_end(status);
           });
  };
  return {rpc, &Request::default_instance(), serve};
}

template <typename Request>
ServedMethod Stream(Rpc rpc) {
  const auto serve = [](ServiceContext& context, ServedCall call, const Caller& caller) {
    auto load = PagesOf(caller, static_cast<const Request&>(*call.request));
    context.access.refusals().TellEnd(call.peer, load.status());
    if (!load.ok()) return call.on_end(load.status());
    std::make_shared<Pages>(context, std::move(call))->Begin(caller, *std::move(load));
  };
  return {rpc, &Request::default_instance(), serve};
}

const auto& AllMethods() {
  static const auto& methods = *new std::array{
      Unary<v1::ListPosteriorsRequest, v1::ListPosteriorsResponse>(
          RpcOf("PosteriorsService/ListPosteriors")),
      Unary<v1::GetPosteriorRequest, v1::GetPosteriorResponse>(
          RpcOf("PosteriorsService/GetPosterior")),
      Unary<v1::ListSessionsRequest, v1::ListSessionsResponse>(
          RpcOf("SessionsService/ListSessions")),
      Unary<v1::KickSessionRequest, v1::KickSessionResponse>(RpcOf("SessionsService/KickSession")),
      Unary<v1::OrderSessionRequest, v1::OrderSessionResponse>(
          RpcOf("SessionsService/OrderSession")),
      Unary<v1::ListAlertsRequest, v1::ListAlertsResponse>(RpcOf("AlertsService/ListAlerts")),
      Unary<v1::SilenceAlertRequest, v1::SilenceAlertResponse>(RpcOf("AlertsService/SilenceAlert")),
      Unary<v1::UnsilenceAlertRequest, v1::UnsilenceAlertResponse>(
          RpcOf("AlertsService/UnsilenceAlert")),
      Unary<v1::RevokePriorsRequest, v1::RevokePriorsResponse>(RpcOf("PriorsService/RevokePriors")),
      Unary<v1::PromotePriorsRequest, v1::PromotePriorsResponse>(
          RpcOf("PriorsService/PromotePriors")),
      Unary<v1::GetHistoryRequest, v1::GetHistoryResponse>(RpcOf("HistoryService/GetHistory")),
      Stream<v1::ExportPriorsRequest>(RpcOf("PriorsService/ExportPriors")),
      Stream<v1::CompareBuildsRequest>(RpcOf("PriorsService/CompareBuilds")),
      Stream<v1::ListAuditSegmentsRequest>(RpcOf("AuditService/ListAuditSegments")),
      Unary<v1::ListDecisionsRequest, v1::ListDecisionsResponse>(
          RpcOf("AuditService/ListDecisions")),
      Stream<v1::ExportDecisionsRequest>(RpcOf("AuditService/ExportDecisions"))};
  return methods;
}

template <typename Matches>
const ServedMethod* Find(Matches matches) {
  const auto found = std::find_if(AllMethods().begin(), AllMethods().end(), matches);
  return found == AllMethods().end() ? nullptr : &*found;
}

}  // namespace

const ServedMethod* FindMethod(std::string_view name) {
  return Find([&](const ServedMethod& method) { return method.rpc.name == name; });
}

const ServedMethod* FindMethod(const google::protobuf::Descriptor* request) {
  return Find(
      [&](const ServedMethod& method) { return method.request->GetDescriptor() == request; });
}

bool BeginHttpCall(ServiceContext& context, ServedCall call,
                   const std::optional<std::string>& token) {
  const ServedMethod* method = FindMethod(call.request->GetDescriptor());
  if (method == nullptr) return false;
  const auto caller = context.access.AuthorizeOverHttp(call.peer, token, method->rpc);
  call.on_end = [&context, end = std::move(call.on_end)](const absl::Status& status) {
    CountError(status, context.counters);
    end(status);
  };
  caller.ok() ? method->serve(context, std::move(call), *caller) : call.on_end(caller.status());
  return true;
}

}  // namespace sweepstake::rpc
