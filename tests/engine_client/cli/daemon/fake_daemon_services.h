// A daemon's services for reading and adding evidence, on a port of its own, with scripted answers.
// The test fills in the answers before it calls; the service's threads only read them, and record
// the requests.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::test_support {

// What the service's threads write and the test reads.
template <typename T>
class Recorded {
 public:
  T get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }
  // Calls `change` with the value.
  template <typename Change>
  void Update(const Change& change) {
    const std::lock_guard lock(mutex_);
    change(value_);
  }

 private:
  mutable std::mutex mutex_;
  T value_;
};

class FakePosteriors final : public v1::PosteriorsService::Service {
 public:
  std::vector<v1::ListPosteriorsResponse> pages;  // the token of page N is "N"
  std::vector<v1::WatchPosteriorsResponse> events;
  bool ends_the_watch = true;                   // otherwise it waits for the client to go
  Recorded<std::vector<std::string>> projects;  // of the requests
  Recorded<std::string> watched_scene;

 private:
  grpc::Status ListPosteriors(grpc::ServerContext*, const v1::ListPosteriorsRequest* request,
                              v1::ListPosteriorsResponse* response) override;
  grpc::Status WatchPosteriors(grpc::ServerContext* context,
                               const v1::WatchPosteriorsRequest* request,
                               grpc::ServerWriter<v1::WatchPosteriorsResponse>* writer) override;
};

class FakePriors final : public v1::PriorsService::Service {
 public:
  std::vector<v1::ExportPriorsResponse> parts;
  grpc::Status import_status;
  Recorded<std::vector<int>> imported_sizes;  // records per message
  Recorded<std::vector<v1::PriorRecord>> imported;
  Recorded<v1::ExportPriorsRequest> export_request;

 private:
  grpc::Status ExportPriors(grpc::ServerContext*, const v1::ExportPriorsRequest* request,
                            grpc::ServerWriter<v1::ExportPriorsResponse>* writer) override;
  grpc::Status ImportPriors(grpc::ServerContext*,
                            grpc::ServerReader<v1::ImportPriorsRequest>* reader,
                            v1::ImportPriorsResponse* response) override;
};

class FakeAudit final : public v1::AuditService::Service {
 public:
  std::vector<v1::ListAuditSegmentsResponse> segments;
  std::vector<v1::ExportDecisionsResponse> parts;
  grpc::Status export_status;
  Recorded<v1::ExportDecisionsRequest> export_request;

 private:
  grpc::Status ListAuditSegments(
      grpc::ServerContext*, const v1::ListAuditSegmentsRequest* request,
      grpc::ServerWriter<v1::ListAuditSegmentsResponse>* writer) override;
  grpc::Status ExportDecisions(grpc::ServerContext*, const v1::ExportDecisionsRequest* request,
                               grpc::ServerWriter<v1::ExportDecisionsResponse>* writer) override;
};

class FakeDaemonServices {
 public:
  FakeDaemonServices();
  ~FakeDaemonServices();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  FakePosteriors posteriors;
  FakePriors priors;
  FakeAudit audit;

 private:
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace sweepstake::test_support
