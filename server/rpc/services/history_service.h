// sweepstake.v1.HistoryService: reads the history of games. Thread-safe.
//
// A page token contains the last series of its page. A token of another form is INVALID_ARGUMENT.
#pragma once

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/history.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::GetHistoryRequest& request,
            v1::GetHistoryResponse& response, const EndCall& end);

}  // namespace sweepstake::rpc
