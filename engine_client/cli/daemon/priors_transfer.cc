#include "engine_client/cli/daemon/priors_transfer.h"

#include <algorithm>

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/telemetry/proto_conversion.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

// The protocol's maximum.
constexpr size_t kRecordsPerMessage = 200;

}  // namespace

Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project,
                                              const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context);
  v1::ExportPriorsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  const auto reader = stub->ExportPriors(&context, request);
  std::vector<PriorRecord> records;
  v1::ExportPriorsResponse part;
  while (reader->Read(&part)) {
    for (const v1::PriorRecord& message : part.records()) records.push_back(FromProto(message));
  }
  const Status status = ToStatus(reader->Finish(), daemon);
  if (!status.ok()) return status;
  return records;
}

Result<ImportResult> ImportPriors(const DaemonOptions& daemon,
                                  std::span<const PriorRecord> records) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context);
  v1::ImportPriorsResponse response;
  const auto writer = stub->ImportPriors(&context, &response);
  while (!records.empty()) {
    const auto part = records.first(std::min(kRecordsPerMessage, records.size()));
    records = records.subspan(part.size());
    v1::ImportPriorsRequest request;
    for (const PriorRecord& record : part) *request.add_records() = ToProto(record);
    // If the daemon refuses a message, Finish returns the reason.
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const Status status = ToStatus(writer->Finish(), daemon);
  if (!status.ok()) return status;
  return ImportResult{response.applied_count(), response.unchanged_count()};
}

}  // namespace sweepstake::cli
