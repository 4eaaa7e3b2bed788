// sweepstake.v1.AuditService: lists and exports the audit log from the store. Thread-safe.
//
// An export reads the store page by page, as fast as the client reads. A call that lists rows reads
// at most kRowsPerList rows.
#pragma once

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/page_stream.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake::rpc {

void Answer(ServiceContext& context, const Caller& caller, const v1::ListDecisionsRequest& request,
            v1::ListDecisionsResponse& response, const EndCall& end);
absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ListAuditSegmentsRequest& request);
absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportDecisionsRequest& request);

}  // namespace sweepstake::rpc
