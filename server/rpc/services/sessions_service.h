// sweepstake.v1.SessionsService: lists and ends the sessions in memory, and gives orders to
// their games. Thread-safe.
#pragma once

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListSessionsRequest& request,
            v1::ListSessionsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::KickSessionRequest& request,
            v1::KickSessionResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::OrderSessionRequest& request,
            v1::OrderSessionResponse& response, const EndCall& end);

}  // namespace sweepstake::rpc
