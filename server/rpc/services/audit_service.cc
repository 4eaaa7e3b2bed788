#include "server/rpc/services/audit_service.h"

#include <algorithm>
#include <compare>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/decision_rows.h"
#include "server/rpc/services/page_stream.h"

namespace sweepstake::rpc {
namespace {

using priors::AuditFilter;
using priors::AuditOrder;
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

// The position of an export in the audit log.
struct RowPlace {
  uint64_t after = 0;                   // id of the segment that was begun last; 0: none
  std::optional<AuditSegment> segment;  // the segment being exported
  uint64_t next_row = 1;                // the next row of `segment`
  bool has_setup = false;               // the setup of `segment` was sent, if it has one
};

// Sets place.segment to the next segment that matches, unless it is set. Returns false if there are
// no more segments.
absl::StatusOr<bool> EnterSegment(priors::PriorReader& store, const AuditFilter& filter,
                                  RowPlace& place) {
  if (place.segment) return true;
  const auto segments = store.ListAudit(filter, place.after, 1);
  if (!segments.ok()) return segments.status();
  if (segments->empty()) return false;
  place = {.after = segments->front().id, .segment = segments->front()};
  return true;
}

// Returns a row that stands for missing rows, beginning with row `number` of the segment.
v1::AuditRow MissingRow(const AuditSegment& segment, uint64_t number) {
  v1::AuditRow message;
  message.set_session(segment.session_id);
  message.set_segment(segment.segment);
  message.set_row(number);
  message.set_kind(v1::AUDIT_KIND_MISSING);
  return message;
}

// Exports the rows of all matching segments.
class DecisionExport {
 public:
  DecisionExport(AuditFilter filter, const v1::DecisionFilter& rows)
      : filter_(std::move(filter)), rows_(rows) {}

  absl::StatusOr<StreamPage> Load(priors::PriorReader& store) {
    response_ = std::make_shared<v1::ExportDecisionsResponse>();
    size_t read_bytes = 0;
    sent_bytes_ = 0;
    while (sent_bytes_ < kAuditBytesPerMessage && read_bytes < kAuditBytesPerRead) {
      const auto entered = EnterSegment(store, filter_, place_);
      if (!entered.ok()) return entered.status();
      if (!*entered) return StreamPage{.response = response_, .last = true};
      const auto rows = store.LoadAudit(place_.segment->id, place_.next_row, kAuditRowsPerPage,
                                        kAuditBytesPerMessage - sent_bytes_);
      if (!rows.ok()) return rows.status();
      if (rows->empty()) {
        place_.segment.reset();
        setups_ = {};  // an export of a large log would keep one for each segment
      }
      for (const priors::StoredAuditRow& row : *rows) {
        read_bytes += row.bytes.size();
        if (absl::Status status = Add(store, row); !status.ok()) return status;
      }
    }
    return StreamPage{.response = response_};
  }

 private:
  // Adds a row. One row of the kind AUDIT_KIND_MISSING stands for each gap in the row numbers and
  // for each row that does not parse.
  absl::Status Add(priors::PriorReader& store, const priors::StoredAuditRow& row) {
    const AuditSegment& segment = *place_.segment;
    const auto setup = setups_.Load(store, segment.id);
    if (!setup.ok()) return setup.status();
    if (row.number != place_.next_row) AddIfSelected(MissingRow(segment, place_.next_row), *setup);
    place_.next_row = row.number + 1;
    v1::AuditRow message;
    if (!message.ParseFromString(row.bytes)) message = MissingRow(segment, row.number);
    if (AddIfSelected(std::move(message), *setup)) sent_bytes_ += row.bytes.size();
    return absl::OkStatus();
  }

  bool AddIfSelected(v1::AuditRow row, const v1::AuditSetup* setup) {
    if (!rows_.Matches(row, setup)) return false;
    if (!std::exchange(place_.has_setup, true) && setup != nullptr)
      AddSetup(row, *setup, *response_);
    *response_->add_rows() = std::move(row);
    return true;
  }

  const AuditFilter filter_;
  const RowFilter rows_;
  SegmentSetups setups_;
  RowPlace place_;
  std::shared_ptr<v1::ExportDecisionsResponse> response_;  // the page that is being made
  size_t sent_bytes_ = 0;
};

// The place of a row. Within one session it is the row's segment and number. Among the rows of all
// sessions, `row` is its id, and `segment` is 0.
struct Place {
  uint64_t segment = 0;
  uint64_t row = 0;

  friend auto operator<=>(const Place&, const Place&) = default;
};

// A request for a page of rows, after its checks.
struct ListQuery {
  AuditFilter filter;
  RowFilter rows;
  uint32_t limit;
  AuditOrder order;
  std::optional<Place> start;  // the page begins after this place
  uint64_t decision_id;        // 0: rows of any kind
  Place only;                  // the only row to read; {0, 0}: all rows

  bool is_newest_first() const { return order == AuditOrder::kNewestFirst; }
  bool is_of_session() const { return !filter.session_id.empty(); }
};

// Collects a page of the rows that a query examines.
class DecisionPage {
 public:
  explicit DecisionPage(const ListQuery& query) : query_(query) {}

  // Adds a row if it matches.
  absl::Status Examine(priors::PriorReader& store, uint64_t segment_id, Place place,
                       const std::string& bytes) {
    Pass(place);
    ++examined_count_;
    v1::AuditRow row;
    if (!row.ParseFromString(bytes)) return absl::OkStatus();
    if (query_.decision_id != 0 && row.decision().id() != query_.decision_id)
      return absl::OkStatus();
    absl::StatusOr<const v1::AuditSetup*> setup = nullptr;
    if (query_.rows.has_times()) setup = setups_.Load(store, segment_id);
    if (!setup.ok()) return setup.status();
    if (!query_.rows.Matches(row, *setup)) return absl::OkStatus();
    setup = setups_.Load(store, segment_id);
    if (!setup.ok()) return setup.status();
    if (has_setups_.insert(segment_id).second && *setup != nullptr)
      AddSetup(row, **setup, response_);
    *response_.add_rows() = std::move(row);
    bytes_ += bytes.size();
    return absl::OkStatus();
  }
  // Notes that the rows up to this place are examined.
  void Pass(Place place) {
    if (!first_) first_ = place;
    last_ = place;
  }
  // Returns whether the page ends with the latest row.
  bool full() const {
    return room() == 0 || bytes_ >= kListBytes || examined_count_ >= kRowsPerList;
  }
  uint32_t room() const { return query_.limit - static_cast<uint32_t>(response_.rows_size()); }
  SegmentSetups& setups() { return setups_; }

  // Returns the page. `has_more`: more rows follow it.
  v1::ListDecisionsResponse Take(bool has_more) {
    const std::optional<Place>& start = query_.start;
    const Place first{.segment = query_.is_of_session() ? 1u : 0u, .row = 1};
    Place newest;
    Place oldest;
    // If no row was examined, the next page of either direction begins where this one did.
    if (query_.is_newest_first()) {
      newest = first_.value_or(start ? Place{start->segment, start->row - 1} : Place{});
      oldest = last_.value_or(start.value_or(first));
    } else {
      newest = last_.value_or(*start);
      oldest = first_.value_or(Place{start->segment, start->row + 1});
      std::reverse(response_.mutable_rows()->begin(), response_.mutable_rows()->end());
    }
    response_.set_newer_token(TokenOf(newest));
    response_.set_older_token(TokenOf(oldest));
    response_.set_has_more(has_more);
    return std::move(response_);
  }

 private:
  std::string TokenOf(Place place) const {
    return query_.is_of_session() ? absl::StrCat(place.segment, ".", place.row)
                                  : absl::StrCat(place.row);
  }

  const ListQuery& query_;
  SegmentSetups setups_;
  std::set<uint64_t> has_setups_;  // ids of the segments whose setups are in the response
  v1::ListDecisionsResponse response_;
  std::optional<Place> first_;  // the row that was examined first
  std::optional<Place> last_;   // the row that was examined last
  size_t bytes_ = 0;
  uint32_t examined_count_ = 0;
};

absl::StatusOr<v1::ListDecisionsResponse> ListAll(priors::PriorReader& store,
                                                  const ListQuery& query) {
  DecisionPage page(query);
  uint64_t last_id = query.start ? query.start->row : 0;
  for (uint32_t i = 0; i < kScansPerList && !page.full(); ++i) {
    const auto scan = store.ScanAudit(query.filter, query.order, last_id,
                                      query.rows.empty() ? page.room() : kAuditRowsPerPage);
    if (!scan.ok()) return scan.status();
    if (scan->last_id == last_id) return page.Take(/*has_more=*/false);
    page.Pass({.row = scan->first_id});
    for (const priors::PlacedAuditRow& placed : scan->rows) {
      if (page.full()) return page.Take(/*has_more=*/true);
      absl::Status status =
          page.Examine(store, placed.segment_id, {.row = placed.id}, placed.row.bytes);
      if (!status.ok()) return status;
    }
    last_id = scan->last_id;
    page.Pass({.row = last_id});
    if (scan->at_end) return page.Take(/*has_more=*/false);
  }
  return page.Take(/*has_more=*/true);
}

// A range of row numbers within a segment.
struct RowRange {
  uint64_t begin = 1;
  uint64_t end = 1;  // exclusive

  bool empty() const { return begin >= end; }
};

// A property of rows that grows within a segment, such as their time. Nothing: the row has none.
using RowKey = std::function<std::optional<int64_t>(const v1::AuditRow&)>;

// Returns the number of the first row in the range whose key is at least `least`; range.end if
// there is none.
// REQUIRES: rows without a key are rare, as in the log of a game.
absl::StatusOr<uint64_t> FirstRowWith(priors::PriorReader& store, uint64_t segment_id,
                                      RowRange range, const RowKey& key, int64_t least) {
  const uint64_t end = range.end;
  uint64_t found = end;
  while (!range.empty()) {
    const uint64_t middle = range.begin + (range.end - range.begin) / 2;
    std::optional<int64_t> value;
    uint64_t number = middle;
    while (!value && number < end) {
      const auto rows = store.LoadAudit(segment_id, number, 1, priors::kMaxAuditRowBytes);
      if (!rows.ok()) return rows.status();
      v1::AuditRow row;
      if (!rows->empty() && row.ParseFromString(rows->front().bytes)) value = key(row);
      number = rows->empty() ? end : rows->front().number + 1;
    }
    if (value && *value < least) {
      range.begin = number;
    } else {
      range.end = middle;
      if (value) found = number - 1;
    }
  }
  return found;
}

// Lists the rows of one session, segment by segment.
class SessionList {
 public:
  explicit SessionList(const ListQuery& query) : query_(query), page_(query) {}

  absl::StatusOr<v1::ListDecisionsResponse> Load(priors::PriorReader& store) {
    const auto segments = SegmentsOf(store);
    if (!segments.ok()) return segments.status();
    for (const AuditSegment& segment : *segments) {
      auto range = RangeOf(store, segment);
      if (!range.ok()) return range.status();
      while (!range->empty()) {
        if (page_.full()) return page_.Take(/*has_more=*/true);
        if (absl::Status status = Examine(store, segment, *range); !status.ok()) return status;
      }
    }
    return page_.Take(/*has_more=*/false);
  }

 private:
  // Returns the session's segments, in the order of the query.
  absl::StatusOr<std::vector<AuditSegment>> SegmentsOf(priors::PriorReader& store) {
    std::vector<AuditSegment> all;
    while (true) {
      const auto part =
          store.ListAudit(query_.filter, all.empty() ? 0 : all.back().id, kAuditSegmentsPerMessage);
      if (!part.ok()) return part.status();
      all.insert(all.end(), part->begin(), part->end());
      if (part->size() < kAuditSegmentsPerMessage) break;
    }
    if (query_.is_newest_first()) std::reverse(all.begin(), all.end());
    return all;
  }

  // Returns the rows of the segment that the query selects by their place, time or decision.
  absl::StatusOr<RowRange> RangeOf(priors::PriorReader& store, const AuditSegment& segment) {
    RowRange range{segment.first_row,
                   segment.first_row + segment.row_count + segment.lost_row_count};
    if (const auto& start = query_.start) {
      const bool is_passed = query_.is_newest_first() ? segment.segment > start->segment
                                                      : segment.segment < start->segment;
      if (is_passed) return RowRange{};
      if (segment.segment == start->segment && query_.is_newest_first())
        range.end = std::min(range.end, start->row);
      else if (segment.segment == start->segment)
        range.begin = std::max(range.begin, start->row + 1);
    }
    if (query_.only.segment != 0) {
      if (query_.only.segment != segment.segment) return RowRange{};
      range = {std::max(range.begin, query_.only.row), std::min(range.end, query_.only.row + 1)};
    }
    if (query_.decision_id != 0) {
      const RowKey key = [](const v1::AuditRow& row) -> std::optional<int64_t> {
        if (!row.has_decision()) return std::nullopt;
        return static_cast<int64_t>(row.decision().id());
      };
      const auto found =
          FirstRowWith(store, segment.id, range, key, static_cast<int64_t>(query_.decision_id));
      if (!found.ok()) return found.status();
      range = {*found, std::min(range.end, *found + 1)};
    }
    return query_.rows.has_times() ? WithinTimes(store, segment.id, range) : range;
  }

  absl::StatusOr<RowRange> WithinTimes(priors::PriorReader& store, uint64_t segment_id,
                                       RowRange range) {
    const auto setup = page_.setups().Load(store, segment_id);
    if (!setup.ok()) return setup.status();
    const RowKey key = [&](const v1::AuditRow& row) { return UnixMsOf(row, *setup); };
    const RowFilter& rows = query_.rows;
    if (rows.unix_until_ms() != 0) {
      const auto end = FirstRowWith(store, segment_id, range, key, rows.unix_until_ms());
      if (!end.ok()) return end.status();
      range.end = *end;
    }
    const auto begin = FirstRowWith(store, segment_id, range, key, rows.unix_from_ms());
    if (!begin.ok()) return begin.status();
    range.begin = *begin;
    return range;
  }

  // Examines the next rows of the range, and removes them from it.
  absl::Status Examine(priors::PriorReader& store, const AuditSegment& segment, RowRange& range) {
    const bool is_newest_first = query_.is_newest_first();
    RowRange next = range;
    if (is_newest_first)
      next.begin = std::max(range.begin, range.end - std::min<uint64_t>(range.end, query_.limit));
    else
      next.end = std::min(range.end, range.begin + query_.limit);
    auto rows = store.LoadAudit(segment.id, next.begin, query_.limit,
                                query_.limit * priors::kMaxAuditRowBytes);
    if (!rows.ok()) return rows.status();
    if (is_newest_first) std::reverse(rows->begin(), rows->end());
    for (const priors::StoredAuditRow& row : *rows) {
      if (row.number < next.begin || row.number >= next.end) continue;
      if (page_.full()) return absl::OkStatus();
      absl::Status status =
          page_.Examine(store, segment.id, {segment.segment, row.number}, row.bytes);
      if (!status.ok()) return status;
      is_newest_first ? range.end = row.number : range.begin = row.number + 1;
    }
    is_newest_first ? range.end = next.begin : range.begin = next.end;
    return absl::OkStatus();
  }

  const ListQuery& query_;
  DecisionPage page_;
};

// Returns the filter of the request, restricted to the projects that the caller may see.
template <typename Selection>
absl::StatusOr<AuditFilter> FilterOf(const Caller& caller, const Selection& selection) {
  AuditFilter filter{selection.session_id(), selection.project(), selection.scene()};
  if (absl::Status allowed = Narrow(caller, filter); !allowed.ok()) return allowed;
  return filter;
}

absl::Status InvalidQuery(absl::string_view problem) {
  return Refused(v1::ERROR_REASON_INVALID_MESSAGE, problem);
}

// Parses a token of DecisionPage. Returns nothing if it is invalid.
std::optional<Place> PlaceIn(absl::string_view token, bool is_of_session) {
  constexpr uint64_t kLastRow = std::numeric_limits<int64_t>::max() - 1;
  Place place;
  if (is_of_session) {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(token, absl::MaxSplits('.', 1));
    if (!absl::SimpleAtoi(parts.first, &place.segment)) return std::nullopt;
    token = parts.second;
  }
  if (!absl::SimpleAtoi(token, &place.row) || place.row > kLastRow) return std::nullopt;
  return place;
}

absl::StatusOr<ListQuery> QueryOf(const Caller& caller, const v1::ListDecisionsRequest& request) {
  auto filter = FilterOf(caller, request.filter());
  if (!filter.ok()) return filter.status();
  const bool reads_newer = !request.newer_than().empty();
  const std::string& token = reads_newer ? request.newer_than() : request.older_than();
  ListQuery query{.filter = *std::move(filter),
                  .rows = RowFilter(request.filter()),
                  .limit = request.page_size() == 0
                               ? kDecisionsPerPage
                               : std::min(request.page_size(), kDecisionsPerPage),
                  .order = reads_newer ? AuditOrder::kOldestFirst : AuditOrder::kNewestFirst,
                  .start = token.empty() ? std::nullopt
                                         : PlaceIn(token, !request.filter().session_id().empty()),
                  .decision_id = request.decision_id(),
                  .only = {request.segment(), request.row()}};
  if (reads_newer && !request.older_than().empty())
    return InvalidQuery("set only one of older_than and newer_than");
  if (!token.empty() && (!query.start || (!reads_newer && query.start->row == 0)))
    return InvalidQuery(
        "older_than and newer_than must be tokens of a response with the same filter");
  const bool is_one_row = request.segment() != 0 || request.row() != 0;
  if (is_one_row && (request.segment() == 0 || request.row() == 0))
    return InvalidQuery("segment and row must be set together");
  if (request.decision_id() != 0 && request.filter().session_id() == decision::kAdminSession)
    return InvalidQuery("the log of administrators has no decisions");
  if ((is_one_row || request.decision_id() != 0) && !query.is_of_session())
    return InvalidQuery("segment, row and decision_id need filter.session_id");
  return query;
}

}  // namespace

void Answer(ServiceContext& context, const Caller& caller, const v1::ListDecisionsRequest& request,
            v1::ListDecisionsResponse& response, const EndCall& end) {
  auto query = QueryOf(caller, request);
  if (!query.ok()) return end(query.status());
  // Large answers are completed on the reading thread, not on the decision loop.
  const bool submitted =
      context.store.Read([query = *std::move(query), &response, end](priors::PriorReader& store) {
        auto page = query.is_of_session() ? SessionList(query).Load(store) : ListAll(store, query);
        if (page.ok()) response = *std::move(page);
        end(page.ok() ? absl::OkStatus() : StoreFailed(page.status()));
      });
  if (!submitted) end(StoreBusy());
}

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
  auto filter = FilterOf(caller, request.filter());
  if (!filter.ok()) return filter.status();
  const auto running = std::make_shared<DecisionExport>(*std::move(filter), request.filter());
  return LoadPage([running](priors::PriorReader& store) { return running->Load(store); });
}

}  // namespace sweepstake::rpc
