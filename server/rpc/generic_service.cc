#include "server/rpc/generic_service.h"

#include <string_view>

#include "server/rpc/common/refused_call.h"
#include "server/rpc/services/one_request_call.h"
#include "server/rpc/services/watch_call.h"
#include "sweepstake/v1/alerts.grpc.pb.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/history.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::rpc {
namespace {

constexpr std::string_view kPackage = "/sweepstake.v1.";

// Services without handlers. They give reflection the names of the services; the calls go to the
// generic service.
template <typename Service>
Service& Named() {
  static Service service;
  return service;
}

using Telemetry =
    v1::TelemetryService::WithGenericMethod_StreamTelemetry<v1::TelemetryService::Service>;
using Posteriors = v1::PosteriorsService::WithGenericMethod_ListPosteriors<
    v1::PosteriorsService::WithGenericMethod_GetPosterior<
        v1::PosteriorsService::WithGenericMethod_WatchPosteriors<v1::PosteriorsService::Service>>>;
using Sessions = v1::SessionsService::WithGenericMethod_ListSessions<
    v1::SessionsService::WithGenericMethod_WatchSessions<
        v1::SessionsService::WithGenericMethod_KickSession<
            v1::SessionsService::WithGenericMethod_OrderSession<
                v1::SessionsService::WithGenericMethod_WatchBoxes<v1::SessionsService::Service>>>>>;
using Audit = v1::AuditService::WithGenericMethod_ListAuditSegments<
    v1::AuditService::WithGenericMethod_ListDecisions<
        v1::AuditService::WithGenericMethod_ExportDecisions<v1::AuditService::Service>>>;
using HistoryReads = v1::HistoryService::WithGenericMethod_GetHistory<v1::HistoryService::Service>;
using Alerts = v1::AlertsService::WithGenericMethod_ListAlerts<
    v1::AlertsService::WithGenericMethod_SilenceAlert<
        v1::AlertsService::WithGenericMethod_UnsilenceAlert<v1::AlertsService::Service>>>;
using Priors = v1::PriorsService::WithGenericMethod_ExportPriors<
    v1::PriorsService::WithGenericMethod_ImportPriors<
        v1::PriorsService::WithGenericMethod_RevokePriors<
            v1::PriorsService::WithGenericMethod_PromotePriors<
                v1::PriorsService::WithGenericMethod_CompareBuilds<v1::PriorsService::Service>>>>>;

const Rpc* FindRpc(std::string_view path) {
  if (!path.starts_with(kPackage)) return nullptr;
  for (const Rpc& rpc : kRoleTable) {
    if (rpc.name == path.substr(kPackage.size())) return &rpc;
  }
  return nullptr;
}

}  // namespace

void GenericService::Register(grpc::ServerBuilder& builder) {
  builder.RegisterCallbackGenericService(this);
  builder.RegisterService(&Named<Telemetry>());
  builder.RegisterService(&Named<Posteriors>());
  builder.RegisterService(&Named<Sessions>());
  builder.RegisterService(&Named<Alerts>());
  builder.RegisterService(&Named<Audit>());
  builder.RegisterService(&Named<HistoryReads>());
  builder.RegisterService(&Named<Priors>());
}

grpc::ServerGenericBidiReactor* GenericService::CreateReactor(
    grpc::GenericCallbackServerContext* call) {
  if (auto* reactor = health_.Serve(call->method())) return reactor;
  const Rpc* rpc = FindRpc(call->method());
  if (rpc == nullptr)
    return new RefusedCall({grpc::StatusCode::UNIMPLEMENTED, "the daemon has no such method"});
  auto caller = context_.access.Authorize(*call, *rpc);
  if (!caller.ok()) return new RefusedCall(ToGrpc(caller.status(), context_.counters));
  if (const ServedMethod* method = FindMethod(rpc->name))
    return new OneRequestCall(context_, *method, *call, *std::move(caller));
  if (const auto kind = WatchedBy(rpc->name))
    return ServeWatch(context_, *call, *kind, *std::move(caller));
  return rpc->name == RpcOf("PriorsService/ImportPriors").name
             ? imports_.Serve(*call, *std::move(caller))
             : telemetry_.Serve(*call, *std::move(caller));
}

}  // namespace sweepstake::rpc
