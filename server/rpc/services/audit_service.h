// sweepstake.v1.AuditService: exports the audit log from the store. Thread-safe.
//
// It reads the store page by page, as fast as the client reads.
#pragma once

#include "server/rpc/services/page_stream.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake::rpc {

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ListAuditSegmentsRequest& request);
absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportDecisionsRequest& request);

}  // namespace sweepstake::rpc
