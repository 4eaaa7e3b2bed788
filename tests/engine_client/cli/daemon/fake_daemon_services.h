// Fakes of a daemon's services with scripted answers, on their own port.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/v1/alerts.grpc.pb.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::test_support {

// A value that the test and the service's threads share. `guarded->member()` holds the lock for the
// whole expression.
template <typename T>
class Guarded {
 public:
  class Handle {
   public:
    explicit Handle(Guarded& guarded) : lock_(guarded.mutex_), value_(guarded.value_) {}
    T* operator->() const { return &value_; }

   private:
    std::lock_guard<std::mutex> lock_;
    T& value_;
  };

  Guarded& operator=(T value) {
    const std::lock_guard lock(mutex_);
    value_ = std::move(value);
    return *this;
  }
  Handle operator->() { return Handle(*this); }
  T get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  T value_;
};

class FakePosteriors final : public v1::PosteriorsService::Service {
 public:
  Guarded<std::vector<v1::ListPosteriorsResponse>> pages;  // the token of page N is "N"
  Guarded<std::vector<v1::WatchPosteriorsResponse>> events;
  std::atomic<bool> ends_the_watch =
      true;                          // false: the stream stays open until the client cancels it
  std::atomic<int> watch_count = 0;  // watches beyond `watch_limit` are refused
  std::atomic<int> watch_limit = 2;
  Guarded<std::vector<std::string>> projects;  // project of each request
  Guarded<std::string> listed_scene;
  Guarded<std::string> watched_scene;

 private:
  grpc::Status ListPosteriors(grpc::ServerContext*, const v1::ListPosteriorsRequest* request,
                              v1::ListPosteriorsResponse* response) override;
  grpc::Status WatchPosteriors(grpc::ServerContext* context,
                               const v1::WatchPosteriorsRequest* request,
                               grpc::ServerWriter<v1::WatchPosteriorsResponse>* writer) override;
};

class FakePriors final : public v1::PriorsService::Service {
 public:
  Guarded<std::vector<v1::ExportPriorsResponse>> parts;
  Guarded<grpc::Status> import_status;
  Guarded<std::vector<int>> imported_sizes;  // records per message
  Guarded<std::vector<v1::PriorRecord>> imported;
  Guarded<v1::ExportPriorsRequest> export_request;
  Guarded<v1::RevokePriorsRequest> revoke_request;
  Guarded<v1::RevokePriorsResponse> revoke_response;
  Guarded<v1::PromotePriorsRequest> promote_request;
  Guarded<v1::PromotePriorsResponse> promote_response;
  std::atomic<int64_t> patience_s = 0;  // deadline of the latest revocation or promotion, in s
  std::atomic<bool> promotes = false;   // `promote` in the latest message of an import

 private:
  grpc::Status PromotePriors(grpc::ServerContext*, const v1::PromotePriorsRequest* request,
                             v1::PromotePriorsResponse* response) override;
  grpc::Status RevokePriors(grpc::ServerContext*, const v1::RevokePriorsRequest* request,
                            v1::RevokePriorsResponse* response) override;
  grpc::Status ExportPriors(grpc::ServerContext*, const v1::ExportPriorsRequest* request,
                            grpc::ServerWriter<v1::ExportPriorsResponse>* writer) override;
  grpc::Status ImportPriors(grpc::ServerContext*,
                            grpc::ServerReader<v1::ImportPriorsRequest>* reader,
                            v1::ImportPriorsResponse* response) override;
};

class FakeAudit final : public v1::AuditService::Service {
 public:
  Guarded<std::vector<v1::ListAuditSegmentsResponse>> segments;
  Guarded<std::vector<v1::ExportDecisionsResponse>> parts;
  Guarded<grpc::Status> export_status;
  Guarded<v1::ExportDecisionsRequest> export_request;

 private:
  grpc::Status ListAuditSegments(
      grpc::ServerContext*, const v1::ListAuditSegmentsRequest* request,
      grpc::ServerWriter<v1::ListAuditSegmentsResponse>* writer) override;
  grpc::Status ExportDecisions(grpc::ServerContext*, const v1::ExportDecisionsRequest* request,
                               grpc::ServerWriter<v1::ExportDecisionsResponse>* writer) override;
};

class FakeSessions final : public v1::SessionsService::Service {
 public:
  Guarded<std::vector<v1::ListSessionsResponse>> pages;  // the token of page N is "N"
  Guarded<std::vector<v1::WatchSessionsResponse>> events;
  std::atomic<int> watch_count = 0;  // all watches after the first are refused
  Guarded<v1::KickSessionRequest> kick_request;
  Guarded<grpc::Status> kick_status;
  Guarded<v1::OrderSessionRequest> order_request;  // the response names the request's arm, or "SAP"

 private:
  grpc::Status ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest* request,
                            v1::ListSessionsResponse* response) override;
  // Ends the stream after the last event.
  grpc::Status WatchSessions(grpc::ServerContext*, const v1::WatchSessionsRequest* request,
                             grpc::ServerWriter<v1::WatchSessionsResponse>* writer) override;
  grpc::Status KickSession(grpc::ServerContext*, const v1::KickSessionRequest* request,
                           v1::KickSessionResponse* response) override;
  grpc::Status OrderSession(grpc::ServerContext*, const v1::OrderSessionRequest* request,
                            v1::OrderSessionResponse* response) override;
};

class FakeAlerts final : public v1::AlertsService::Service {
 public:
  Guarded<v1::ListAlertsResponse> list;
  Guarded<v1::ListAlertsRequest> list_request;

 private:
  grpc::Status ListAlerts(grpc::ServerContext*, const v1::ListAlertsRequest* request,
                          v1::ListAlertsResponse* response) override;
};

class FakeDaemonServices {
 public:
  FakeDaemonServices();
  ~FakeDaemonServices();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  FakePosteriors posteriors;
  FakePriors priors;
  FakeAudit audit;
  FakeSessions sessions;
  FakeAlerts alerts;

 private:
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace sweepstake::test_support
