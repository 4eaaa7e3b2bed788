#include "tests/engine_client/cli/daemon/fake_daemon_services.h"

#include <chrono>
#include <thread>

namespace sweepstake::test_support {
namespace {

// Returns the seconds until the deadline of the call.
int64_t SecondsLeft(const grpc::ServerContext& context) {
  const auto left = context.deadline() - std::chrono::system_clock::now();
  return std::chrono::duration_cast<std::chrono::seconds>(left).count();
}

}  // namespace

grpc::Status FakePosteriors::ListPosteriors(grpc::ServerContext*,
                                            const v1::ListPosteriorsRequest* request,
                                            v1::ListPosteriorsResponse* response) {
  projects->push_back(request->project());
  listed_scene = request->scene();
  const size_t page = request->page_token().empty() ? 0 : std::stoul(request->page_token());
  *response = pages->at(page);
  if (page + 1 < pages->size()) response->set_next_page_token(std::to_string(page + 1));
  return grpc::Status::OK;
}

grpc::Status FakePosteriors::WatchPosteriors(
    grpc::ServerContext* context, const v1::WatchPosteriorsRequest* request,
    grpc::ServerWriter<v1::WatchPosteriorsResponse>* writer) {
  if (++watch_count > watch_limit) return {grpc::StatusCode::PERMISSION_DENIED, "not any more"};
  watched_scene = request->scene();
  for (const v1::WatchPosteriorsResponse& event : events.get()) writer->Write(event);
  while (!ends_the_watch && !context->IsCancelled()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return grpc::Status::OK;
}

grpc::Status FakePriors::ExportPriors(grpc::ServerContext*, const v1::ExportPriorsRequest* request,
                                      grpc::ServerWriter<v1::ExportPriorsResponse>* writer) {
  export_request = *request;
  for (const v1::ExportPriorsResponse& part : parts.get()) writer->Write(part);
  return grpc::Status::OK;
}

grpc::Status FakePriors::PromotePriors(grpc::ServerContext* context,
                                       const v1::PromotePriorsRequest* request,
                                       v1::PromotePriorsResponse* response) {
  promote_request = *request;
  patience_s = SecondsLeft(*context);
  *response = promote_response.get();
  return grpc::Status::OK;
}

grpc::Status FakePriors::ImportPriors(grpc::ServerContext*,
                                      grpc::ServerReader<v1::ImportPriorsRequest>* reader,
                                      v1::ImportPriorsResponse* response) {
  v1::ImportPriorsRequest request;
  while (reader->Read(&request)) {
    imported_sizes->push_back(request.records_size());
    promotes = request.promote();
    for (const v1::PriorRecord& record : request.records()) imported->push_back(record);
  }
  response->set_applied_count(imported->size() - 1);
  response->set_unchanged_count(1);
  return import_status.get();
}

grpc::Status FakePriors::RevokePriors(grpc::ServerContext* context,
                                      const v1::RevokePriorsRequest* request,
                                      v1::RevokePriorsResponse* response) {
  revoke_request = *request;
  patience_s = SecondsLeft(*context);
  *response = revoke_response.get();
  return grpc::Status::OK;
}

grpc::Status FakeAudit::ListAuditSegments(
    grpc::ServerContext*, const v1::ListAuditSegmentsRequest*,
    grpc::ServerWriter<v1::ListAuditSegmentsResponse>* writer) {
  for (const v1::ListAuditSegmentsResponse& part : segments.get()) writer->Write(part);
  return grpc::Status::OK;
}

grpc::Status FakeAudit::ExportDecisions(grpc::ServerContext*,
                                        const v1::ExportDecisionsRequest* request,
                                        grpc::ServerWriter<v1::ExportDecisionsResponse>* writer) {
  export_request = *request;
  for (const v1::ExportDecisionsResponse& part : parts.get()) writer->Write(part);
  return export_status.get();
}

grpc::Status FakeSessions::ListSessions(grpc::ServerContext*,
                                        const v1::ListSessionsRequest* request,
                                        v1::ListSessionsResponse* response) {
  const size_t page = request->page_token().empty() ? 0 : std::stoul(request->page_token());
  *response = pages->at(page);
  if (page + 1 < pages->size()) response->set_next_page_token(std::to_string(page + 1));
  return grpc::Status::OK;
}

grpc::Status FakeSessions::WatchSessions(grpc::ServerContext*, const v1::WatchSessionsRequest*,
                                         grpc::ServerWriter<v1::WatchSessionsResponse>* writer) {
  if (++watch_count > 1) return {grpc::StatusCode::PERMISSION_DENIED, "not any more"};
  for (const v1::WatchSessionsResponse& event : events.get()) writer->Write(event);
  return grpc::Status::OK;
}

grpc::Status FakeSessions::OrderSession(grpc::ServerContext*,
                                        const v1::OrderSessionRequest* request,
                                        v1::OrderSessionResponse* response) {
  order_request = *request;
  response->set_mode(request->mode());
  response->set_active_arm(request->arm().empty() ? "SAP" : request->arm());
  return grpc::Status::OK;
}

grpc::Status FakeSessions::KickSession(grpc::ServerContext*, const v1::KickSessionRequest* request,
                                       v1::KickSessionResponse*) {
  kick_request = *request;
  return kick_status.get();
}

grpc::Status FakeAlerts::ListAlerts(grpc::ServerContext*, const v1::ListAlertsRequest* request,
                                    v1::ListAlertsResponse* response) {
  list_request = *request;
  *response = list.get();
  return grpc::Status::OK;
}

FakeDaemonServices::FakeDaemonServices() {
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
  builder.RegisterService(&posteriors);
  builder.RegisterService(&priors);
  builder.RegisterService(&audit);
  builder.RegisterService(&sessions);
  builder.RegisterService(&alerts);
  server_ = builder.BuildAndStart();
}

FakeDaemonServices::~FakeDaemonServices() {
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
}

}  // namespace sweepstake::test_support
