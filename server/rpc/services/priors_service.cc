#include "server/rpc/services/priors_service.h"

#include <spdlog/logger.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/page_stream.h"
#include "server/rpc/services/unary_call.h"
#include "server/rpc/sessions/admin_log.h"
#include "server/rpc/sessions/scene_quota.h"
#include "server/rpc/sessions/session_table.h"
#include "server/text/names.h"

namespace sweepstake::rpc {
namespace {

using priors::PriorRecord;
using ExportStream = PageStream<v1::ExportPriorsResponse, priors::ExportPlace>;

absl::StatusOr<ExportStream::Page> LoadRecords(priors::PriorReader& store,
                                               const priors::SceneFilter& filter,
                                               const priors::ExportPlace& after) {
  const auto stored = store.Export(filter, after, kRecordsPerMessage);
  if (!stored.ok()) return stored.status();
  ExportStream::Page page;
  page.empty = stored->records.empty() && stored->folded_record_count == 0;
  page.last = stored->records.size() < kRecordsPerMessage;
  for (const PriorRecord& record : stored->records) ToProto(record, *page.response.add_records());
  page.response.set_folded_record_count(stored->folded_record_count);
  page.response.set_folded_window_count(stored->folded_window_count);
  page.next = stored->next;
  return page;
}

// One import. gRPC's callbacks parse and check one message at a time and post to the decision loop,
// where everything else happens but the store's job.
class PriorImport final : public grpc::ServerReadReactor<grpc::ByteBuffer>, public StallingCall {
 public:
  // `collected_count` is shared by all imports.
  PriorImport(ServiceContext& context, AdminLog& admin, std::atomic<size_t>& collected_count,
              grpc::CallbackServerContext& call, grpc::ByteBuffer& response, auth::Principal caller)
      : context_(context),
        admin_(admin),
        collected_count_(collected_count),
        call_(call),
        response_(response),
        caller_(std::move(caller)) {
    context_.loop.Post([this] { Begin(); });
  }
  ~PriorImport() override { collected_count_ -= records_.size(); }

  void OnReadDone(bool ok) override {
    if (!ok) return context_.loop.Post([this] { OnHalfClose(); });
    context_.loop.Post([this, status = Take()] { status.ok() ? ReadNext() : End(status); });
  }
  void OnDone() override {
    context_.loop.Post([this] { delete this; });
  }
  int64_t waiting_since_ns() const override { return last_progress_ns_; }
  int64_t deadline_ns() const override { return deadline_ns_; }
  void OnStalled() override {
    context_.stalls.Remove(*this);
    const absl::Status stalled = Refused(
        v1::ERROR_REASON_CALL_STALLED, "no records came, or not all in time; nothing was imported");
    context_.access.refusals().TellEnd(CallerOf(call_), stalled);
    Cancel(call_, ToGrpc(stalled, context_.counters));
  }

 private:
  void Begin() {
    last_progress_ns_ = context_.loop.clock().NowNs();
    deadline_ns_ = last_progress_ns_ + context_.options.transfer_patience_ns;
    context_.stalls.Add(*this);
    auto transfer = context_.access.BeginTransfer(caller_, v1::ERROR_REASON_TOO_MANY_IMPORTS);
    if (!transfer.ok()) return End(transfer.status());
    transfer_ = *std::move(transfer);
    ReadNext();
  }

  // Not for a token that was revoked meanwhile.
  void ReadNext() {
    if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
      return End(still);
    last_progress_ns_ = context_.loop.clock().NowNs();
    StartRead(&bytes_);
  }

  void OnHalfClose() {
    // A lost connection must not count as the end of the records.
    if (call_.IsCancelled())
      return End(absl::CancelledError("the stream broke off; nothing was imported"));
    if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
      return End(still);
    last_progress_ns_ = deadline_ns_ = Clock::kNever;  // the store's turn
    const bool submitted = context_.store.Submit([this](priors::PriorStore& store) {
      if (const absl::Status allowed = CheckQuota(store); !allowed.ok())
        return context_.loop.Post([this, allowed] { End(allowed); });
      // Behind what was read before of the store, as commits are.
      context_.loop.PostLater([this, result = store.Import(records_)] { OnImported(result); });
    });
    if (!submitted)
      End(Refused(v1::ERROR_REASON_STORE_BUSY,
                  "the prior store has too much to do; import again later"));
  }

  absl::Status CheckQuota(priors::PriorStore& store) {
    SceneQuota quota(store, context_.options);
    for (const PriorRecord& record : records_) {
      const priors::EvidenceKey& key = record.key;
      const priors::SceneKey scene{key.project, key.scene, key.machine_class, key.reward_version};
      absl::Status status = quota.Add(scene, {key.arm, key.backend_version});
      if (!status.ok()) return status;
    }
    new_scenes_ = quota.new_scenes();
    return absl::OkStatus();
  }

  void OnImported(const absl::StatusOr<priors::ImportResult>& result) {
    if (absl::IsUnavailable(result.status())) context_.watch_hub.Reset();  // it may have them
    if (!result.ok()) return End(StoreFailed(result.status()));
    // Sessions that hold them would otherwise count them a second time.
    for (const priors::SceneKey& scene : new_scenes_) context_.sessions.new_scenes().Forget(scene);
    v1::ImportPriorsResponse answer;
    answer.set_applied_count(result->applied_count);
    answer.set_unchanged_count(result->unchanged_count);
    response_ = Serialize(answer);
    context_.log.info("{} imported {} records, {} of them new or newer", NameForLog(caller_),
                      records_.size(), result->applied_count);
    admin_.Record(
        absl::StrCat("action=import records=", records_.size(), " applied=", result->applied_count),
        NameAndAddress(caller_, call_));
    context_.watch_hub.Reset();
    End(absl::OkStatus());
  }

  void End(const absl::Status& status) {
    context_.stalls.Remove(*this);  // gRPC frees the call once it is finished
    context_.access.refusals().TellEnd(CallerOf(call_), status);
    Finish(ToGrpc(status, context_.counters));
  }

  absl::Status Take() {
    if (!Parse(bytes_, request_)) {
      ++context_.counters.malformed_message_count;
      return Refused(v1::ERROR_REASON_MALFORMED_MESSAGE,
                     "a message does not parse as sweepstake.v1.ImportPriorsRequest");
    }
    if (request_.records_size() > static_cast<int>(kRecordsPerMessage)) {
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                     absl::StrCat("a message may hold ", kRecordsPerMessage, " records"));
    }
    for (const v1::PriorRecord& record : request_.records()) {
      if (records_.size() == kMaxImportRecords) {
        return Refused(
            v1::ERROR_REASON_IMPORT_TOO_LARGE,
            absl::StrCat("an import may hold ", kMaxImportRecords, " records; split it"));
      }
      if (collected_count_ >= 2 * size_t{kMaxImportRecords}) {
        return Refused(v1::ERROR_REASON_TOO_MANY_IMPORTS,
                       "other imports are under way; import again later");
      }
      if (const absl::Status status = CheckPriorRecord(record); !status.ok()) {
        return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                       absl::StrCat("record ", records_.size(), ": ", status.message()));
      }
      if (absl::Status allowed = CheckProject(caller_, record.project()); !allowed.ok())
        return allowed;
      records_.push_back(FromProto(record));
      ++collected_count_;
    }
    return absl::OkStatus();
  }

  ServiceContext& context_;
  AdminLog& admin_;
  std::atomic<size_t>& collected_count_;
  grpc::CallbackServerContext& call_;
  grpc::ByteBuffer& response_;
  const auth::Principal caller_;
  AccessControl::Share transfer_;  // used on the loop, as the next two
  int64_t last_progress_ns_ = 0;
  int64_t deadline_ns_ = Clock::kNever;
  grpc::ByteBuffer bytes_;
  v1::ImportPriorsRequest request_;
  std::vector<PriorRecord> records_;
  std::vector<priors::SceneKey> new_scenes_;  // that the store gets; used by its job, then the loop
};

// Returns which sources a revocation means.
absl::StatusOr<priors::SourceFilter> FilterOf(const v1::RevokePriorsRequest& request,
                                              const auth::Principal& caller) {
  const bool names_any = !request.source_id().empty() || !request.build().empty() ||
                         request.token_id() != 0 || request.unix_from_s() != 0 ||
                         request.unix_until_s() != 0;
  if (!names_any || request.token_id() < 0 || request.unix_from_s() < 0 ||
      request.unix_until_s() < 0) {
    return Refused(
        v1::ERROR_REASON_INVALID_MESSAGE,
        "name the sources to revoke: by source_id, build, token_id, or a time since 1970");
  }
  for (const std::string* name : {&request.project(), &request.source_id(), &request.build()}) {
    if (!text::IsOptionalName(*name))
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE, "a name has at most 128 bytes of UTF-8");
  }
  if (absl::Status allowed = CheckProject(caller, request.project()); !allowed.ok()) return allowed;
  priors::SourceFilter filter{.id = request.source_id(),
                              .project = request.project(),
                              .build = request.build(),
                              .token_id = request.token_id(),
                              .from_unix_s = static_cast<uint64_t>(request.unix_from_s())};
  if (request.unix_until_s() != 0)
    filter.until_unix_s = static_cast<uint64_t>(request.unix_until_s());
  return filter;
}

}  // namespace

grpc::ServerWriteReactor<v1::ExportPriorsResponse>* PriorsService::ExportPriors(
    grpc::CallbackServerContext* call, const v1::ExportPriorsRequest* request) {
  priors::SceneFilter filter{request->project(), request->scene()};
  const auto caller = context_.access.Authorize(*call, RpcOf("PriorsService/ExportPriors"));
  absl::Status allowed = caller.status();
  if (allowed.ok()) {
    allowed = Narrow(*caller, filter);
    context_.access.refusals().TellEnd(CallerOf(*call), allowed);
  }
  if (!allowed.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<v1::ExportPriorsResponse>>(
        ToGrpc(allowed, context_.counters));
  }
  return ExportStream::Start(
      context_, *call, *caller,
      [filter](priors::PriorReader& store, const priors::ExportPlace& after) {
        return LoadRecords(store, filter, after);
      });
}

grpc::ServerReadReactor<grpc::ByteBuffer>* PriorsService::ImportPriors(
    grpc::CallbackServerContext* call, grpc::ByteBuffer* response) {
  auto caller = context_.access.Authorize(*call, RpcOf("PriorsService/ImportPriors"));
  if (caller.ok()) {
    return new PriorImport(context_, admin_, collected_count_, *call, *response,
                           *std::move(caller));
  }
  return new RefusedCall<grpc::ServerReadReactor<grpc::ByteBuffer>>(
      ToGrpc(caller.status(), context_.counters));
}

grpc::ServerUnaryReactor* PriorsService::RevokePriors(grpc::CallbackServerContext* call,
                                                      const v1::RevokePriorsRequest* request,
                                                      v1::RevokePriorsResponse* response) {
  constexpr Rpc kRpc = RpcOf("PriorsService/RevokePriors");
  return ServeUnary(context_, *call, kRpc, [&](const auth::Principal& caller, EndCall end) {
    auto filter = FilterOf(*request, caller);
    if (!filter.ok()) return end(filter.status());
    const bool submitted =
        context_.store.Submit([this, request, response, end, filter = *std::move(filter),
                               who = NameAndAddress(caller, *call)](priors::PriorStore& store) {
          const auto result = store.Revoke(filter, request->preview());
          // Behind what was read before of the store, as commits are.
          context_.loop.PostLater([this, request, response, end, who, result] {
            if (!result.ok()) return end(StoreFailed(result.status()));
            response->set_source_count(result->source_count);
            response->set_record_count(result->record_count);
            response->set_window_count(result->window_count);
            if (!request->preview()) OnRevoked(*request, *result, who);
            end(absl::OkStatus());
          });
        });
    if (!submitted)
      end(Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store has too much to do; try later"));
  });
}

void PriorsService::OnRevoked(const v1::RevokePriorsRequest& request,
                              const priors::RevokeResult& result, const std::string& who) {
  const std::string what =
      absl::StrCat("sources=", result.source_count, " records=", result.record_count,
                   " project=", request.project(), " source=", request.source_id(),
                   " build=", request.build(), " token=", request.token_id(),
                   " from=", request.unix_from_s(), " until=", request.unix_until_s());
  context_.log.warn("{} revoked evidence: {}", who, what);
  admin_.Record("action=revoke " + what, who);
  context_.watch_hub.Reset();
}

}  // namespace sweepstake::rpc
