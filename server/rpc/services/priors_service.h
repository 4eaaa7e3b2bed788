// sweepstake.v1.PriorsService: exports evidence from the store and imports it. Thread-safe.
//
// An export reads the store page by page, as fast as the client reads. Records that are committed
// during the export may be missing, but no record is partial. An import is collected first (up to
// kMaxImportRecords) and applied in one transaction after the client has half-closed; a stream that
// is cancelled or has an invalid record changes nothing. Imported evidence waits in quarantine
// until it is promoted, and then reaches the sessions that begin after it.
#pragma once

#include <atomic>

#include "server/rpc/services/service_context.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::sessions {
class AdminLog;
}

namespace sweepstake::rpc {

class PriorsService final : public v1::PriorsService::WithCallbackMethod_ExportPriors<
                                v1::PriorsService::WithRawCallbackMethod_ImportPriors<
                                    v1::PriorsService::WithCallbackMethod_RevokePriors<
                                        v1::PriorsService::WithCallbackMethod_PromotePriors<
                                            v1::PriorsService::WithCallbackMethod_CompareBuilds<
                                                v1::PriorsService::Service>>>>> {
 public:
  PriorsService(ServiceContext& context, sessions::AdminLog& admin)
      : context_(context), admin_(admin) {}

  grpc::ServerWriteReactor<v1::ExportPriorsResponse>* ExportPriors(
      grpc::CallbackServerContext* call, const v1::ExportPriorsRequest* request) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* ImportPriors(grpc::CallbackServerContext* call,
                                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* RevokePriors(grpc::CallbackServerContext* call,
                                         const v1::RevokePriorsRequest* request,
                                         v1::RevokePriorsResponse* response) override;
  grpc::ServerUnaryReactor* PromotePriors(grpc::CallbackServerContext* call,
                                          const v1::PromotePriorsRequest* request,
                                          v1::PromotePriorsResponse* response) override;
  grpc::ServerWriteReactor<v1::CompareBuildsResponse>* CompareBuilds(
      grpc::CallbackServerContext* call, const v1::CompareBuildsRequest* request) override;

 private:
  // Logs a revocation or a promotion that was committed.
  void OnChanged(const std::string& action, const std::string& who);

  ServiceContext& context_;
  sessions::AdminLog& admin_;
  std::atomic<size_t> collected_count_{0};  // records in memory, of all current imports
};

}  // namespace sweepstake::rpc
