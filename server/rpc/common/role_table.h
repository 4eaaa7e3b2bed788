// The role that each RPC needs. A handler names its RPC with RpcOf, which does not compile for an
// RPC without a row. A test checks that each RPC in proto/ has a row.
#pragma once

#include <array>
#include <string_view>

#include "server/auth/principal.h"

namespace sweepstake::rpc {

struct Rpc {
  std::string_view name;  // SERVICE/METHOD, as in the path of the call without the package
  auth::Role role;
};

inline constexpr std::array kRoleTable = {
    Rpc{"TelemetryService/StreamTelemetry", auth::Role::kIngest},
    Rpc{"PosteriorsService/ListPosteriors", auth::Role::kWatch},
    Rpc{"PosteriorsService/GetPosterior", auth::Role::kWatch},
    Rpc{"PosteriorsService/WatchPosteriors", auth::Role::kWatch},
    Rpc{"SessionsService/ListSessions", auth::Role::kWatch},
    Rpc{"SessionsService/WatchSessions", auth::Role::kWatch},
    Rpc{"SessionsService/KickSession", auth::Role::kOperator},
    Rpc{"SessionsService/OrderSession", auth::Role::kOperator},
    Rpc{"SessionsService/WatchBoxes", auth::Role::kOperator},
    Rpc{"AuditService/ListAuditSegments", auth::Role::kWatch},
    Rpc{"AuditService/ListDecisions", auth::Role::kWatch},
    Rpc{"AuditService/ExportDecisions", auth::Role::kWatch},
    Rpc{"HistoryService/GetHistory", auth::Role::kWatch},
    Rpc{"AlertsService/ListAlerts", auth::Role::kWatch},
    Rpc{"AlertsService/SilenceAlert", auth::Role::kOperator},
    Rpc{"AlertsService/UnsilenceAlert", auth::Role::kOperator},
    Rpc{"PriorsService/ExportPriors", auth::Role::kWatch},
    Rpc{"PriorsService/ImportPriors", auth::Role::kOperator},
    Rpc{"PriorsService/RevokePriors", auth::Role::kOperator},
    Rpc{"PriorsService/PromotePriors", auth::Role::kOperator},
    Rpc{"PriorsService/CompareBuilds", auth::Role::kWatch},
};

consteval Rpc RpcOf(std::string_view name) {
  for (const Rpc& rpc : kRoleTable) {
    if (rpc.name == name) return rpc;
  }
  throw "the RPC has no row in kRoleTable";
}

}  // namespace sweepstake::rpc
