#include "engine_client/cli/daemon/daemon_calls.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/client_reports.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "engine_client/telemetry/conversion/proto_conversion.h"
#include "sweepstake/v1/alerts.grpc.pb.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::cli {
namespace {

constexpr uint32_t kMaxAlerts = 2'000;  // as many as a daemon has

// The commands that show whether a change was made.
constexpr char kListPriors[] = "sweepstake priors list";
constexpr char kListSessions[] = "sweepstake sessions list";

template <typename Request>
Request RequestOf(const std::string& project, const std::string& scene) {
  Request request;
  request.set_project(project);
  request.set_scene(scene);
  return request;
}

template <typename Request>
Request RequestOf(const AuditSelection& selection) {
  auto request = RequestOf<Request>(selection.project, selection.scene);
  request.set_session_id(selection.session_id);
  return request;
}

template <typename Request>
Request RequestOf(const v1::SourceFilter& sources, bool preview) {
  Request request;
  *request.mutable_sources() = sources;
  request.set_preview(preview);
  return request;
}

// Returns how many records belong to a source that has no evidence in the daemon under the record's
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

}  // namespace

Result<std::vector<v1::AuditSegment>> ListAudit(const DaemonOptions& daemon,
                                                const AuditSelection& selection) {
  std::vector<v1::AuditSegment> segments;
  const Status status =
      ReadParts(daemon, RequestOf<v1::ListAuditSegmentsRequest>(selection),
                &v1::AuditService::Stub::ListAuditSegments, kPatience,
                [&](const v1::ListAuditSegmentsResponse& part) {
                  segments.insert(segments.end(), part.segments().begin(), part.segments().end());
                });
  if (!status.ok()) return status;
  return segments;
}

Result<uint64_t> ExportAudit(const DaemonOptions& daemon, const AuditSelection& selection,
                             const std::filesystem::path& path) {
  const auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(decision::AuditHeader() + '\n');
  uint64_t row_count = 0;
  v1::ExportDecisionsRequest request;
  *request.mutable_filter() = RequestOf<v1::DecisionFilter>(selection);
  Status status = ReadParts(daemon, request, &v1::AuditService::Stub::ExportDecisions,
                            kTransferPatience, [&](const v1::ExportDecisionsResponse& part) {
                              for (const v1::AuditRow& row : part.rows())
                                (*file)->Write(decision::AuditLines(FromProto(row)) + '\n');
                              row_count += static_cast<uint64_t>(part.rows_size());
                            });
  const bool selects =
      !selection.session_id.empty() || !selection.project.empty() || !selection.scene.empty();
  if (status.ok() && selects && row_count == 0) {
    return Status(StatusCode::kNotFound,
                  "the daemon has no matching decisions, and " + path.string() +
                      " was not changed; `sweepstake audit list` shows which decisions exist");
  }
  if (status.ok()) status = (*file)->Commit();
  if (!status.ok()) return status;
  return row_count;
}

Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  std::vector<v1::ScenePosterior> scenes;
  auto request = RequestOf<v1::ListPosteriorsRequest>(project, scene);
  do {
    const auto page = Call(daemon, channel, request, &v1::PosteriorsService::Stub::ListPosteriors);
    if (!page.ok()) return page.status();
    scenes.insert(scenes.end(), page->scenes().begin(), page->scenes().end());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event,
                       const std::function<void(const Status&)>& on_connection) {
  return KeepWatching(daemon, RequestOf<v1::WatchPosteriorsRequest>(project, scene),
                      &v1::PosteriorsService::Stub::WatchPosteriors, is_stopped, on_event,
                      on_connection);
}

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
  auto request = RequestOf<v1::ExportPriorsRequest>(project, scene);
  request.set_quarantined_only(what == Exported::kQuarantined);
  return ReadParts(daemon, request, &v1::PriorsService::Stub::ExportPriors, kTransferPatience,
                   [&](const v1::ExportPriorsResponse& part) {
                     for (const v1::PriorRecord& message : part.records())
                       on_record(FromProto(message));
                   });
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
    const auto part = records.first(std::min<size_t>(protocol::kRecordsPerMessage, records.size()));
    records = records.subspan(part.size());
    v1::ImportPriorsRequest request;
    request.set_promote(promote);
    for (const PriorRecord& record : part) *request.add_records() = ToProto(record);
    // If Write fails, the daemon has refused a message; Finish then returns the reason.
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const grpc::Status ended = writer->Finish();
  const Status status = ToStatus(ended, daemon, WasConnected(**channel), kListPriors);
  if (!status.ok()) return status;
  ImportCounts result = {response.applied_count(), response.unchanged_count()};
  if (result.unchanged_count > 0) result.absent_count = CountAbsent(daemon, all_records);
  return result;
}

Result<v1::PromotePriorsResponse> PromotePriors(const DaemonOptions& daemon,
                                                const v1::SourceFilter& sources, bool preview) {
  return Call(daemon, OpenChannel(daemon), RequestOf<v1::PromotePriorsRequest>(sources, preview),
              &v1::PriorsService::Stub::PromotePriors, kTransferPatience,
              preview ? "" : kListPriors);
}

Result<v1::RevokePriorsResponse> RevokePriors(const DaemonOptions& daemon,
                                              const v1::SourceFilter& sources, bool preview) {
  return Call(daemon, OpenChannel(daemon), RequestOf<v1::RevokePriorsRequest>(sources, preview),
              &v1::PriorsService::Stub::RevokePriors, kTransferPatience,
              preview ? "" : kListPriors);
}

Result<std::vector<v1::SessionInfo>> ListSessions(const DaemonOptions& daemon,
                                                  const std::string& project,
                                                  const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  std::vector<v1::SessionInfo> sessions;
  auto request = RequestOf<v1::ListSessionsRequest>(project, scene);
  do {
    auto page = Call(daemon, channel, request, &v1::SessionsService::Stub::ListSessions);
    if (!page.ok()) return page.status();
    for (v1::SessionInfo& each : *page->mutable_sessions()) sessions.push_back(std::move(each));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

Status WatchSessions(const DaemonOptions& daemon, const std::string& project,
                     const std::string& scene, const std::function<bool()>& is_stopped,
                     const std::function<void(const v1::WatchSessionsResponse&)>& on_event,
                     const std::function<void(const Status&)>& on_connection) {
  return KeepWatching(daemon, RequestOf<v1::WatchSessionsRequest>(project, scene),
                      &v1::SessionsService::Stub::WatchSessions, is_stopped, on_event,
                      on_connection);
}

Status KickSession(const DaemonOptions& daemon, const std::string& session_id, bool may_return) {
  v1::KickSessionRequest request;
  request.set_session_id(session_id);
  request.set_may_return(may_return);
  return Call(daemon, OpenChannel(daemon), request, &v1::SessionsService::Stub::KickSession,
              kPatience, kListSessions)
      .status();
}

Result<v1::OrderSessionResponse> OrderSession(const DaemonOptions& daemon,
                                              const std::string& session_id, v1::Mode mode,
                                              const std::string& arm) {
  v1::OrderSessionRequest request;
  request.set_session_id(session_id);
  request.set_mode(mode);
  request.set_arm(arm);
  return Call(daemon, OpenChannel(daemon), request, &v1::SessionsService::Stub::OrderSession,
              kPatience, kListSessions);
}

Result<v1::ListAlertsResponse> ListAlerts(const DaemonOptions& daemon, const std::string& project) {
  v1::ListAlertsRequest request;
  request.set_project(project);
  request.set_limit(kMaxAlerts);
  return Call(daemon, OpenChannel(daemon), request, &v1::AlertsService::Stub::ListAlerts);
}

}  // namespace sweepstake::cli
