// sweepstake.v1.AuditService: the audit log out of the store. Thread-safe.
//
// Reads the store page by page, as fast as the client reads. Cost: some 1 ms of the store's thread
// for a message of 128 KiB.
#pragma once

#include "server/rpc/services/service_context.h"
#include "sweepstake/v1/audit.grpc.pb.h"

namespace sweepstake::rpc {

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
