#include "engine_client/cli/daemon/priors_transfer.h"

#include <algorithm>

#include "engine_client/cli/daemon/daemon_client.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

// The protocol's bound.
constexpr size_t kRecordsPerMessage = 200;

PriorRecord FromWire(const v1::PriorRecord& wire) {
  PriorRecord record;
  record.project = wire.project();
  record.scene = wire.scene();
  record.context_bucket = wire.context_bucket();
  record.arm = wire.arm();
  record.backend_version = wire.backend_version();
  record.machine_class = wire.machine_class();
  record.reward_version = wire.reward_version();
  record.source_id = wire.source_id();
  record.source_sequence = wire.source_sequence();
  record.alpha_increment = wire.alpha_increment();
  record.beta_increment = wire.beta_increment();
  record.window_count = wire.window_count();
  record.bail_out_count = wire.bail_out_count();
  return record;
}

void ToWire(const PriorRecord& record, v1::PriorRecord& wire) {
  wire.set_project(record.project);
  wire.set_scene(record.scene);
  wire.set_context_bucket(record.context_bucket);
  wire.set_arm(record.arm);
  wire.set_backend_version(record.backend_version);
  wire.set_machine_class(record.machine_class);
  wire.set_reward_version(record.reward_version);
  wire.set_source_id(record.source_id);
  wire.set_source_sequence(record.source_sequence);
  wire.set_alpha_increment(record.alpha_increment);
  wire.set_beta_increment(record.beta_increment);
  wire.set_window_count(record.window_count);
  wire.set_bail_out_count(record.bail_out_count);
}

}  // namespace

Result<std::vector<PriorRecord>> ExportPriors(const std::string& address,
                                              const std::string& project,
                                              const std::string& scene) {
  const auto channel = OpenChannel(address);
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
    for (const v1::PriorRecord& wire : part.records()) records.push_back(FromWire(wire));
  }
  const Status status = ToStatus(reader->Finish(), address);
  if (!status.ok()) return status;
  return records;
}

Result<ImportResult> ImportPriors(const std::string& address,
                                  std::span<const PriorRecord> records) {
  const auto channel = OpenChannel(address);
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
    for (const PriorRecord& record : part) ToWire(record, *request.add_records());
    // A refused message shows in Finish.
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const Status status = ToStatus(writer->Finish(), address);
  if (!status.ok()) return status;
  return ImportResult{response.applied_count(), response.unchanged_count()};
}

}  // namespace sweepstake::cli
