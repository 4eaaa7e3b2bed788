// sweepstake.v1.AlertsService: lists and silences alerts. Thread-safe.
#pragma once

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/alerts.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListAlertsRequest& request,
            v1::ListAlertsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::SilenceAlertRequest& request,
            v1::SilenceAlertResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::UnsilenceAlertRequest& request,
            v1::UnsilenceAlertResponse& response, const EndCall& end);

}  // namespace sweepstake::rpc
