#include "engine_client/cli/daemon/audit_transfer.h"

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "sweepstake/v1/audit.grpc.pb.h"

namespace sweepstake::cli {
namespace {

template <typename Request>
Request RequestOf(const AuditSelection& selection) {
  Request request;
  request.set_session_id(selection.session_id);
  request.set_project(selection.project);
  request.set_scene(selection.scene);
  return request;
}

}  // namespace

Result<std::vector<v1::AuditSegment>> ListAudit(const DaemonOptions& daemon,
                                                const AuditSelection& selection) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::AuditService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context);
  const auto reader =
      stub->ListAuditSegments(&context, RequestOf<v1::ListAuditSegmentsRequest>(selection));
  std::vector<v1::AuditSegment> segments;
  v1::ListAuditSegmentsResponse part;
  while (reader->Read(&part)) {
    segments.insert(segments.end(), part.segments().begin(), part.segments().end());
  }
  const Status status = ToStatus(reader->Finish(), daemon);
  if (!status.ok()) return status;
  return segments;
}

Result<uint64_t> ExportAudit(const DaemonOptions& daemon, const AuditSelection& selection,
                             const std::filesystem::path& path) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  const auto stub = v1::AuditService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, kTransferPatience);
  const auto reader =
      stub->ExportDecisions(&context, RequestOf<v1::ExportDecisionsRequest>(selection));
  (*file)->Write(decision::AuditHeader() + '\n');
  uint64_t row_count = 0;
  v1::ExportDecisionsResponse part;
  while (reader->Read(&part)) {
    for (const v1::AuditRow& row : part.rows())
      (*file)->Write(decision::AuditLines(FromProto(row)) + '\n');
    row_count += static_cast<uint64_t>(part.rows_size());
  }
  Status status = ToStatus(reader->Finish(), daemon);
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

}  // namespace sweepstake::cli
