#include "server/rpc/audit_service.h"

#include <memory>
#include <optional>
#include <utility>

#include "server/decision/audit_log.h"
#include "server/rpc/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

using priors::AuditFilter;
using priors::AuditSegment;

// Where an answer is in the log; copied to the store's thread and back.
struct Place {
  uint64_t after = 0;               // segments up to this id are done
  std::optional<uint64_t> segment;  // under way
  uint64_t next_row = 1;            // in it
};

template <typename Response>
struct Page {
  Response response;
  Place next;
  bool last = false;  // nothing follows
};

// On the store's thread.
absl::StatusOr<Page<v1::ListAuditSegmentsResponse>> LoadPage(
    priors::PriorStore& store, const AuditFilter& filter, const Place& place,
    const v1::ListAuditSegmentsResponse& /*kind*/) {
  const auto segments = store.ListAudit(filter, place.after, kAuditSegmentsPerMessage);
  if (!segments.ok()) return segments.status();
  Page<v1::ListAuditSegmentsResponse> page;
  page.last = segments->size() < kAuditSegmentsPerMessage;
  for (const AuditSegment& segment : *segments) {
    v1::AuditSegment& filled = *page.response.add_segments();
    filled.set_session_id(segment.session_id);
    filled.set_segment(segment.segment);
    filled.set_project(segment.project);
    filled.set_scene(segment.scene);
    filled.set_unix_start_ms(segment.unix_start_ms);
    filled.set_row_count(segment.row_count);
    page.next.after = segment.id;
  }
  return page;
}

// Begins the next segment; false: there is none.
absl::StatusOr<bool> EnterSegment(priors::PriorStore& store, const AuditFilter& filter,
                                  Place& place) {
  if (place.segment) return true;
  const auto segments = store.ListAudit(filter, place.after, 1);
  if (!segments.ok()) return segments.status();
  if (segments->empty()) return false;
  place.segment = segments->front().id;
  place.next_row = 1;
  return true;
}

absl::StatusOr<Page<v1::ExportDecisionsResponse>> LoadPage(
    priors::PriorStore& store, const AuditFilter& filter, const Place& place,
    const v1::ExportDecisionsResponse& /*kind*/) {
  Page<v1::ExportDecisionsResponse> page;
  page.next = place;
  if (place.after == 0 && !place.segment) page.response.set_header(decision::AuditHeader());
  for (size_t bytes = 0; bytes < kAuditBytesPerMessage;) {
    const auto entered = EnterSegment(store, filter, page.next);
    if (!entered.ok()) return entered.status();
    page.last = !*entered;
    if (page.last) return page;
    auto rows = store.LoadAudit(*page.next.segment, page.next.next_row, kAuditRowsPerPage,
                                kAuditBytesPerMessage - bytes);
    if (!rows.ok()) return rows.status();
    page.next.next_row += rows->size();
    if (rows->empty()) {
      page.next.after = *page.next.segment;
      page.next.segment.reset();
    }
    for (std::string& row : *rows) {
      bytes += row.size();
      page.response.add_rows(std::move(row));
    }
  }
  return page;
}

// One answer. On the decision loop but for gRPC's reactions, which only post. Owns itself until
// gRPC is done with it; what the store reads for it finds it through a weak pointer.
template <typename Response>
class AuditReader final : public grpc::ServerWriteReactor<Response>,
                          public std::enable_shared_from_this<AuditReader<Response>> {
 public:
  static AuditReader* Start(ServiceContext& context, AuditFilter filter) {
    std::shared_ptr<AuditReader> reader(new AuditReader(context, std::move(filter)));
    AuditReader* raw = reader.get();
    raw->self_ = std::move(reader);
    context.loop.Post([raw] { raw->Load(); });
    return raw;
  }

  void OnWriteDone(bool ok) override {
    context_.loop.Post(
        [this, ok] { ok ? Load() : End(absl::CancelledError("the connection was lost")); });
  }
  // A write under way fails and a page under way is written to nobody: both end here soon.
  void OnCancel() override {}
  void OnDone() override {
    context_.loop.Post([this] { self_.reset(); });
  }

 private:
  AuditReader(ServiceContext& context, AuditFilter filter)
      : context_(context), filter_(std::move(filter)) {}

  void Load() {
    if (page_.last) return End(absl::OkStatus());
    const bool submitted =
        context_.store.Submit([weak = this->weak_from_this(), &loop = context_.loop,
                               filter = filter_, place = page_.next](priors::PriorStore& store) {
          loop.Post([weak, page = LoadPage(store, filter, place, Response())]() mutable {
            if (const auto self = weak.lock()) self->OnPage(std::move(page));
          });
        });
    if (!submitted)
      End(absl::UnavailableError("the prior store has too much to do; ask again later"));
  }

  void OnPage(absl::StatusOr<Page<Response>> page) {
    if (!page.ok()) return End(page.status());
    page_ = *std::move(page);
    this->StartWrite(&page_.response);
  }

  void End(const absl::Status& status) { this->Finish(ToGrpc(status)); }

  ServiceContext& context_;
  const AuditFilter filter_;
  std::shared_ptr<AuditReader> self_;  // until OnDone
  Page<Response> page_;                // written last
};

template <typename Request>
AuditFilter FilterOf(const Request& request) {
  return {request.session_id(), request.project(), request.scene()};
}

}  // namespace

grpc::ServerWriteReactor<v1::ListAuditSegmentsResponse>* AuditService::ListAuditSegments(
    grpc::CallbackServerContext* /*call*/, const v1::ListAuditSegmentsRequest* request) {
  return AuditReader<v1::ListAuditSegmentsResponse>::Start(context_, FilterOf(*request));
}

grpc::ServerWriteReactor<v1::ExportDecisionsResponse>* AuditService::ExportDecisions(
    grpc::CallbackServerContext* /*call*/, const v1::ExportDecisionsRequest* request) {
  return AuditReader<v1::ExportDecisionsResponse>::Start(context_, FilterOf(*request));
}

}  // namespace sweepstake::rpc
