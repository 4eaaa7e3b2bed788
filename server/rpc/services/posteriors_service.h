// sweepstake.v1.PosteriorsService: lists the store's scenes. Thread-safe.
//
// A page token contains the last scene of its page. A token of another form is INVALID_ARGUMENT.
#pragma once

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListPosteriorsRequest& request,
            v1::ListPosteriorsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::GetPosteriorRequest& request,
            v1::GetPosteriorResponse& response, const EndCall& end);

}  // namespace sweepstake::rpc
