// sweepstake.v1.PriorsService: exports evidence from the store and imports it. Thread-safe.
//
// An export reads the store page by page, as fast as the client reads. It can miss records that are
// committed while it runs, but each exported record is complete.
//
// An import is first collected in memory (up to kMaxImportRecords records). After the client has
// half-closed the stream, it is applied in one transaction. A stream that is cancelled or has an
// invalid record changes nothing, and neither does an import that a drain stops. Unless the request
// sets `promote`, imported evidence waits in quarantine until an operator promotes it. Sessions
// that begin after the promotion use it.
#pragma once

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <atomic>

#include "server/rpc/services/end_call.h"
#include "server/rpc/services/page_stream.h"
#include "sweepstake/v1/priors.pb.h"

namespace sweepstake::rpc {

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportPriorsRequest& request);
absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::CompareBuildsRequest& request);
void Answer(ServiceContext& context, const Caller& caller, const v1::RevokePriorsRequest& request,
            v1::RevokePriorsResponse& response, const EndCall& end);
void Answer(ServiceContext& context, const Caller& caller, const v1::PromotePriorsRequest& request,
            v1::PromotePriorsResponse& response, const EndCall& end);

class PriorImports {
 public:
  explicit PriorImports(ServiceContext& context) : context_(context) {}

  // Serves a call of ImportPriors.
  grpc::ServerGenericBidiReactor* Serve(grpc::CallbackServerContext& call, Caller caller);

 private:
  ServiceContext& context_;
  std::atomic<size_t> collected_count_{0};  // records in memory, of all current imports
};

}  // namespace sweepstake::rpc
