// sweepstake.v1.AuditService: exports the audit log from the store. Thread-safe.
//
// It reads the store page by page, as fast as the client reads.
#pragma once

#include "server/rpc/services/page_stream.h"
#include "sweepstake/v1/audit.grpc.pb.h"

namespace sweepstake::rpc {

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ListAuditSegmentsRequest& request);
absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportDecisionsRequest& request);

class AuditService final
    : public v1::AuditService::WithCallbackMethod_ListAuditSegments<
          v1::AuditService::WithCallbackMethod_ExportDecisions<v1::AuditService::Service>> {
 public:
  explicit AuditService(ServiceContext& context) : context_(context) {}

  grpc::ServerWriteReactor<v1::ListAuditSegmentsResponse>* ListAuditSegments(
      grpc::CallbackServerContext* call, const v1::ListAuditSegmentsRequest* request) override;
  grpc::ServerWriteReactor<v1::ExportDecisionsResponse>* ExportDecisions(
      grpc::CallbackServerContext* call, const v1::ExportDecisionsRequest* request) override;

 private:
  ServiceContext& context_;
};

}  // namespace sweepstake::rpc
