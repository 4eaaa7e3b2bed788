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

// Names of players and networks are personal data: only callers who may revoke them receive them.
absl::StatusOr<StreamPage> LoadSegments(priors::PriorReader& store, const AuditFilter& filter,
                                        bool names_parties, uint64_t& after) {
  const auto segments = store.ListAudit(filter, after, kAuditSegmentsPerMessage);
  if (!segments.ok()) return segments.status();
  const auto response = std::make_shared<v1::ListAuditSegmentsResponse>();
  for (const AuditSegment& segment : *segments) {
    v1::AuditSegment& message = *response->add_segments();
    ToProto(segment, message);
    if (!names_parties) {
      message.clear_token_id();
      message.clear_party();
    }
    after = segment.id;
  }
  return StreamPage{.response = response, .last = segments->size() < kAuditSegmentsPerMessage};
}

// The last row that the client already has; 0: none. The export begins with the row after it.
struct LastRead {
  uint32_t segment = 0;
  uint64_t row = 0;
};

// The position of an export in the audit log.
struct RowPlace {
  uint64_t after = 0;                   // id of the segment that was begun last; 0: none
  std::optional<AuditSegment> segment;  // the segment being exported
  uint64_t next_row = 1;                // the next row of `segment`
};

// Sets place.segment to the next segment that matches, unless it is set. Returns false if there are
// no more segments.
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

// Makes `message` a row that stands for missing rows, beginning with row `number` of the segment.
void SetMissing(const AuditSegment& segment, uint64_t number, v1::AuditRow& message) {
  message.Clear();
  message.set_session(segment.session_id);
  message.set_segment(segment.segment);
  message.set_row(number);
  message.set_kind(v1::AUDIT_KIND_MISSING);
}

// Adds the rows to the response. One row of the kind AUDIT_KIND_MISSING stands for each gap in the
// row numbers and for each row that does not parse. Returns the number of bytes of `rows`.
size_t AddRows(const std::vector<priors::StoredAuditRow>& rows, RowPlace& place,
               v1::ExportDecisionsResponse& response) {
  size_t bytes = 0;
  const AuditSegment& segment = *place.segment;
  for (const priors::StoredAuditRow& row : rows) {
    if (row.number != place.next_row) SetMissing(segment, place.next_row, *response.add_rows());
    place.next_row = row.number + 1;
    v1::AuditRow& message = *response.add_rows();
    if (!message.ParseFromString(row.bytes)) SetMissing(segment, row.number, message);
    bytes += row.bytes.size();
  }
  return bytes;
}

absl::StatusOr<StreamPage> LoadRows(priors::PriorReader& store, const AuditFilter& filter,
                                    const LastRead& last_read, RowPlace& place) {
  const auto response = std::make_shared<v1::ExportDecisionsResponse>();
  for (size_t bytes = 0; bytes < kAuditBytesPerMessage;) {
    const auto entered = EnterSegment(store, filter, last_read, place);
    if (!entered.ok()) return entered.status();
    if (!*entered) return StreamPage{.response = response, .last = true};
    auto rows = store.LoadAudit(place.segment->id, place.next_row, kAuditRowsPerPage,
                                kAuditBytesPerMessage - bytes);
    if (!rows.ok()) return rows.status();
    if (rows->empty()) {
      place.segment.reset();
    } else {
      bytes += AddRows(*rows, place, *response);
    }
  }
  return StreamPage{.response = response};
}

// Returns the filter of the request, restricted to the projects that the caller may see.
template <typename Request>
absl::StatusOr<AuditFilter> FilterOf(const Caller& caller, const Request& request) {
  AuditFilter filter{request.session_id(), request.project(), request.scene()};
  if (absl::Status allowed = Narrow(caller, filter); !allowed.ok()) return allowed;
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

absl::StatusOr<LoadPage> PagesOf(const Caller& caller,
                                 const v1::ListAuditSegmentsRequest& request) {
  auto filter = FilterOf(caller, request);
  if (!filter.ok()) return filter.status();
  return LoadPage([filter = *std::move(filter), after = uint64_t{0},
                   names_parties = auth::Includes(caller.role, auth::Role::kOperator)](
                      priors::PriorReader& store) mutable {
    return LoadSegments(store, filter, names_parties, after);
  });
}

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportDecisionsRequest& request) {
  auto filter = FilterOf(caller, request);
  if (!filter.ok()) return filter.status();
  const auto last_read = LastReadOf(request);
  if (!last_read.ok()) return last_read.status();
  return LoadPage([filter = *std::move(filter), last_read = *last_read,
                   place = RowPlace()](priors::PriorReader& store) mutable {
    return LoadRows(store, filter, last_read, place);
  });
}

}  // namespace sweepstake::rpc
