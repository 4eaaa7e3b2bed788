#include "server/rpc/services/audit_service.h"

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/page_stream.h"

namespace sweepstake::rpc {
namespace {

using priors::AuditFilter;
using priors::AuditSegment;

using SegmentStream = PageStream<v1::ListAuditSegmentsResponse, uint64_t>;

absl::StatusOr<SegmentStream::Page> LoadSegments(priors::PriorReader& store,
                                                 const AuditFilter& filter, uint64_t after) {
  const auto segments = store.ListAudit(filter, after, kAuditSegmentsPerMessage);
  if (!segments.ok()) return segments.status();
  SegmentStream::Page page;
  page.last = segments->size() < kAuditSegmentsPerMessage;
  for (const AuditSegment& segment : *segments) {
    ToProto(segment, *page.response.add_segments());
    page.next = segment.id;
  }
  return page;
}

// An export begins after this row of a session; 0: with the first row.
struct LastRead {
  uint32_t segment = 0;
  uint64_t row = 0;
};

// The position of an export in the log.
struct RowPlace {
  uint64_t after = 0;                   // the segments up to this id are done
  std::optional<AuditSegment> segment;  // the current one
  uint64_t next_row = 1;                // the next row of the current segment
};

using RowStream = PageStream<v1::ExportDecisionsResponse, RowPlace>;

// Begins the next segment unless one is current. Returns false if there is none.
absl::StatusOr<bool> EnterSegment(priors::PriorReader& store, const AuditFilter& filter,
                                  const LastRead& last_read, RowPlace& place) {
  while (!place.segment) {
    const auto segments = store.ListAudit(filter, place.after, 1);
    if (!segments.ok()) return segments.status();
    if (segments->empty()) return false;
    const AuditSegment& next = segments->front();
    place.after = next.id;
    if (next.segment < last_read.segment) continue;
    place.segment = next;
    place.next_row = next.segment == last_read.segment ? last_read.row + 1 : 1;
  }
  return true;
}

// Makes the message a row that stands for missing ones.
void SetMissing(const AuditSegment& segment, uint64_t number, v1::AuditRow& message) {
  message.Clear();
  message.set_session(segment.session_id);
  message.set_segment(segment.segment);
  message.set_row(number);
  message.set_kind(v1::AUDIT_KIND_MISSING);
}

// Adds the rows to the response, and a `missing` row where some are not there or not readable.
// Returns their bytes.
size_t AddRows(const std::vector<priors::AuditRow>& rows, RowPlace& place,
               v1::ExportDecisionsResponse& response) {
  size_t bytes = 0;
  const AuditSegment& segment = *place.segment;
  for (const priors::AuditRow& row : rows) {
    if (row.number != place.next_row) SetMissing(segment, place.next_row, *response.add_rows());
    place.next_row = row.number + 1;
    v1::AuditRow& message = *response.add_rows();
    if (!message.ParseFromString(row.bytes)) SetMissing(segment, row.number, message);
    bytes += row.bytes.size();
  }
  return bytes;
}

absl::StatusOr<RowStream::Page> LoadRows(priors::PriorReader& store, const AuditFilter& filter,
                                         const LastRead& last_read, const RowPlace& place) {
  RowStream::Page page;
  page.next = place;
  for (size_t bytes = 0; bytes < kAuditBytesPerMessage;) {
    const auto entered = EnterSegment(store, filter, last_read, page.next);
    if (!entered.ok()) return entered.status();
    page.last = !*entered;
    if (page.last) return page;
    auto rows = store.LoadAudit(page.next.segment->id, page.next.next_row, kAuditRowsPerPage,
                                kAuditBytesPerMessage - bytes);
    if (!rows.ok()) return rows.status();
    if (rows->empty()) {
      page.next.segment.reset();
    } else {
      bytes += AddRows(*rows, page.next, page.response);
    }
  }
  return page;
}

// Returns the part of the request that the caller may see. Refusals are logged.
template <typename Request>
absl::StatusOr<AuditFilter> FilterOf(const absl::StatusOr<auth::Principal>& caller,
                                     const Request& request, const std::string& peer,
                                     RefusalLog& refusals) {
  if (!caller.ok()) return caller.status();
  AuditFilter filter{request.session_id(), request.project(), request.scene()};
  absl::Status status = Narrow(*caller, filter);
  refusals.TellEnd(peer, status);
  if (!status.ok()) return status;
  return filter;
}

absl::StatusOr<LastRead> LastReadOf(const v1::ExportDecisionsRequest& request) {
  const LastRead place{request.after_segment(), request.after_row()};
  const bool is_named = place.segment > 0 && place.row > 0;
  if (is_named ? request.session_id().empty() : place.segment > 0 || place.row > 0)
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "after_segment and after_row must be set together, with session_id");
  constexpr auto kLastRow = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
  if (place.row >= kLastRow)
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE, "after_row is too large for a row number");
  return place;
}

}  // namespace

grpc::ServerWriteReactor<v1::ListAuditSegmentsResponse>* AuditService::ListAuditSegments(
    grpc::CallbackServerContext* call, const v1::ListAuditSegmentsRequest* request) {
  const auto caller = context_.access.Authorize(*call, RpcOf("AuditService/ListAuditSegments"));
  const auto filter = FilterOf(caller, *request, CallerOf(*call), context_.access.refusals());
  if (!filter.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<v1::ListAuditSegmentsResponse>>(
        ToGrpc(filter.status(), context_.counters));
  }
  return SegmentStream::Start(context_, *call, *caller,
                              [filter = *filter](priors::PriorReader& store, uint64_t after) {
                                return LoadSegments(store, filter, after);
                              });
}

grpc::ServerWriteReactor<v1::ExportDecisionsResponse>* AuditService::ExportDecisions(
    grpc::CallbackServerContext* call, const v1::ExportDecisionsRequest* request) {
  const auto caller = context_.access.Authorize(*call, RpcOf("AuditService/ExportDecisions"));
  const auto filter = FilterOf(caller, *request, CallerOf(*call), context_.access.refusals());
  if (!filter.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<v1::ExportDecisionsResponse>>(
        ToGrpc(filter.status(), context_.counters));
  }
  const auto last_read = LastReadOf(*request);
  if (!last_read.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<v1::ExportDecisionsResponse>>(
        ToGrpc(last_read.status(), context_.counters));
  }
  return RowStream::Start(context_, *call, *caller,
                          [filter = *filter, last_read = *last_read](priors::PriorReader& store,
                                                                     const RowPlace& place) {
                            return LoadRows(store, filter, last_read, place);
                          });
}

}  // namespace sweepstake::rpc
