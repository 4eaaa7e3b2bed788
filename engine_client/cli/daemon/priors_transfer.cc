#include "engine_client/cli/daemon/priors_transfer.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/telemetry/conversion/proto_conversion.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

// The maximum number of records in a message of the protocol.
constexpr size_t kRecordsPerMessage = 200;

// Returns the number of records whose source has no evidence in the daemon under the record's
// project and scene. Returns 0 if the daemon's evidence cannot be read.
uint64_t CountAbsent(const DaemonOptions& daemon, std::span<const PriorRecord> records) {
  using Place = std::tuple<std::string, std::string, std::string>;  // project, scene, source
  std::set<std::pair<std::string, std::string>> scenes;
  for (const PriorRecord& record : records) scenes.emplace(record.key.project, record.key.scene);
  std::set<Place> known;
  for (const auto& [project, scene] : scenes) {
    const auto theirs = ExportPriors(daemon, project, scene);
    if (!theirs.ok()) return 0;
    for (const PriorRecord& record : *theirs)
      known.emplace(record.key.project, record.key.scene, record.source_id);
  }
  return static_cast<uint64_t>(
      std::count_if(records.begin(), records.end(), [&](const PriorRecord& record) {
        return !known.contains(Place(record.key.project, record.key.scene, record.source_id));
      }));
}

v1::SourceFilter FilterOf(const SourceChoice& sources) {
  v1::SourceFilter filter;
  filter.set_project(sources.project);
  filter.set_source_id(sources.source_id);
  filter.set_build(sources.build);
  filter.set_token_id(sources.token_id);
  filter.set_unix_from_s(sources.unix_from_s);
  filter.set_unix_until_s(sources.unix_until_s);
  return filter;
}

LeaderChanges LeadersOf(const v1::LeaderChanges& message) {
  LeaderChanges changes{.scenes = {}, .scene_count = message.scene_count()};
  for (const v1::LeaderChange& change : message.scenes()) {
    changes.scenes.push_back({.project = change.project(),
                              .scene = change.scene(),
                              .machine_class = change.machine_class(),
                              .reward_version = change.reward_version(),
                              .arm = change.arm(),
                              .next_arm = change.next_arm()});
  }
  return changes;
}

}  // namespace

Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene,
                                              Exported what) {
  std::vector<PriorRecord> records;
  const Status status = StreamPriors(daemon, project, scene, what, [&](PriorRecord record) {
    records.push_back(std::move(record));
  });
  if (!status.ok()) return status;
  return records;
}

Status StreamPriors(const DaemonOptions& daemon, const std::string& project,
                    const std::string& scene, Exported what,
                    const std::function<void(PriorRecord)>& on_record) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, kTransferPatience);
  v1::ExportPriorsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  request.set_quarantined_only(what == Exported::kQuarantined);
  const auto reader = stub->ExportPriors(&context, request);
  v1::ExportPriorsResponse part;
  while (reader->Read(&part)) {
    for (const v1::PriorRecord& message : part.records()) on_record(FromProto(message));
  }
  return ToStatus(reader->Finish(), daemon);
}

Result<ImportCounts> ImportPriors(const DaemonOptions& daemon,
                                  std::span<const PriorRecord> all_records, bool promote) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, kTransferPatience);
  v1::ImportPriorsResponse response;
  std::span<const PriorRecord> records = all_records;
  const auto writer = stub->ImportPriors(&context, &response);
  while (!records.empty()) {
    const auto part = records.first(std::min(kRecordsPerMessage, records.size()));
    records = records.subspan(part.size());
    v1::ImportPriorsRequest request;
    request.set_promote(promote);
    for (const PriorRecord& record : part) *request.add_records() = ToProto(record);
    // If the daemon refuses a message, Finish returns the reason.
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const Status status = ToStatus(writer->Finish(), daemon);
  if (!status.ok()) return status;
  ImportCounts result = {response.applied_count(), response.unchanged_count()};
  if (result.unchanged_count > 0) result.absent_count = CountAbsent(daemon, all_records);
  return result;
}

Result<RevokeCounts> RevokePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                  bool preview) {
  v1::RevokePriorsRequest request;
  *request.mutable_sources() = FilterOf(sources);
  request.set_preview(preview);
  const auto response = Call(daemon, OpenChannel(daemon), request,
                             &v1::PriorsService::Stub::RevokePriors, kTransferPatience);
  if (!response.ok()) return response.status();
  return RevokeCounts{.source_count = response->source_count(),
                      .record_count = response->record_count(),
                      .window_count = response->window_count(),
                      .leader_changes = LeadersOf(response->leader_changes())};
}

Result<PromoteCounts> PromotePriors(const DaemonOptions& daemon, const SourceChoice& sources,
                                    bool preview) {
  v1::PromotePriorsRequest request;
  *request.mutable_sources() = FilterOf(sources);
  request.set_preview(preview);
  const auto response = Call(daemon, OpenChannel(daemon), request,
                             &v1::PriorsService::Stub::PromotePriors, kTransferPatience);
  if (!response.ok()) return response.status();
  return PromoteCounts{.source_count = response->source_count(),
                       .record_count = response->record_count(),
                       .window_count = response->window_count(),
                       .scene_count = response->scene_count(),
                       .leader_changes = LeadersOf(response->leader_changes())};
}

}  // namespace sweepstake::cli
