#include "server/rpc/services/priors_service.h"

#include <spdlog/logger.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/text/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/leader_preview.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/build_comparison.h"
#include "server/rpc/services/page_stream.h"
#include "server/rpc/services/unary_call.h"
#include "server/sessions/admin_log.h"
#include "server/sessions/scene_quota.h"
#include "server/sessions/session_table.h"
#include "server/sessions/source_weights.h"

namespace sweepstake::rpc {
namespace {

using priors::PriorRecord;

// A place in an export: first the evidence that counts, then the records in quarantine.
struct TransferPlace {
  bool in_quarantine = false;
  priors::ExportPlace after;
};
using ExportStream = PageStream<v1::ExportPriorsResponse, TransferPlace>;

absl::StatusOr<ExportStream::Page> LoadRecords(priors::PriorReader& store,
                                               const priors::SceneFilter& filter,
                                               const TransferPlace& place, bool with_weights) {
  const auto stored = place.in_quarantine
                          ? store.ExportQuarantined(filter, place.after, kRecordsPerMessage)
                          : store.Export(filter, place.after, kRecordsPerMessage);
  if (!stored.ok()) return stored.status();
  const bool ends = stored->records.size() < kRecordsPerMessage;
  if (ends && stored->records.empty() && !place.in_quarantine)
    return LoadRecords(store, filter, {.in_quarantine = true, .after = {}}, with_weights);
  ExportStream::Page page;
  page.empty = stored->records.empty();
  page.last = ends && place.in_quarantine;
  sessions::SourceWeights weights(store);
  for (const PriorRecord& record : stored->records) {
    v1::PriorRecord& message = *page.response.add_records();
    message = ToProto(record);
    if (!with_weights) continue;
    const auto weight = weights.Of(record);
    if (!weight.ok()) return weight.status();
    message.set_weight(*weight);
  }
  page.next = ends ? TransferPlace{.in_quarantine = true, .after = {}}
                   : TransferPlace{place.in_quarantine, stored->next};
  return page;
}

// A place in a comparison. The page behind it continues the comparison.
struct ComparisonPlace {
  priors::ExportPlace after;
  std::shared_ptr<BuildComparison> comparison;
};
using ComparisonStream = PageStream<v1::CompareBuildsResponse, ComparisonPlace>;

absl::StatusOr<ComparisonStream::Page> LoadComparison(priors::PriorReader& store,
                                                      const priors::SceneFilter& filter,
                                                      const ComparisonPlace& place) {
  auto stored = store.Export(filter, place.after, kRecordsPerMessage);
  if (!stored.ok()) return stored.status();
  ComparisonStream::Page page;
  page.next = {stored->next, place.comparison};
  page.last = stored->records.size() < kRecordsPerMessage;
  for (PriorRecord& record : stored->records)
    place.comparison->Add(std::move(record), page.response);
  if (page.last) place.comparison->EndScene(page.response);
  return page;
}

// Called with the result of an import or a promotion.
void OnEvidence(ServiceContext& context, const absl::Status& status,
                const std::vector<priors::SceneKey>& new_scenes) {
  // The store may have the evidence even if it answers UNAVAILABLE.
  if (status.ok() || absl::IsUnavailable(status)) context.events.Reset();
  if (!status.ok()) return;
  // Sessions that hold the scenes would otherwise count them a second time.
  for (const priors::SceneKey& scene : new_scenes) context.sessions.new_scenes().Forget(scene);
}

// One import. gRPC's callbacks parse and check one message at a time and post to the decision loop.
// Everything else runs there, except for the store's job.
class PriorImport final : public grpc::ServerReadReactor<grpc::ByteBuffer>, public StallingCall {
 public:
  // `collected_count` is shared by all imports.
  PriorImport(ServiceContext& context, sessions::AdminLog& admin,
              std::atomic<size_t>& collected_count, grpc::CallbackServerContext& call,
              grpc::ByteBuffer& response, auth::Principal caller)
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

  // Fails if the token was revoked meanwhile.
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
    last_progress_ns_ = deadline_ns_ = sessions::Clock::kNever;  // the daemon waits for the store
    const bool submitted = context_.store.Submit([this](priors::PriorStore& store) {
      if (const absl::Status allowed = CheckQuota(store); !allowed.ok())
        return context_.loop.Post([this, allowed] { End(allowed); });
      const auto result =
          promotes_ ? store.Import(records_) : store.Quarantine(records_, kMaxQuarantinedRecords);
      // PostLater, as for commits: earlier results of the store come first.
      context_.loop.PostLater([this, result] { OnImported(result); });
    });
    if (!submitted)
      End(Refused(v1::ERROR_REASON_STORE_BUSY,
                  "the prior store has too much to do; import again later"));
  }

  absl::Status CheckQuota(priors::PriorStore& store) {
    sessions::SceneQuota quota(store, context_.options);
    for (const PriorRecord& record : records_) {
      absl::Status status = quota.Add(record.key);
      if (!status.ok()) return status;
    }
    new_scenes_ = quota.new_scenes();
    return absl::OkStatus();
  }

  void OnImported(const absl::StatusOr<priors::ImportResult>& result) {
    if (absl::IsResourceExhausted(result.status()))
      return End(Refused(v1::ERROR_REASON_IMPORT_TOO_LARGE, result.status().message()));
    if (promotes_) OnEvidence(context_, result.status(), new_scenes_);
    if (!result.ok()) return End(StoreFailed(result.status()));
    v1::ImportPriorsResponse answer;
    answer.set_applied_count(result->applied_count);
    answer.set_unchanged_count(result->unchanged_count);
    response_ = Serialize(answer);
    const std::string action = absl::StrCat("imported ", records_.size(), " records, ",
                                            result->applied_count, " of them new or newer, which ",
                                            promotes_ ? "count at once" : "wait in quarantine");
    context_.log.info("{} {}", NameForLog(caller_), action);
    admin_.Record(NameAndAddress(caller_, call_), action);
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
    promotes_ = promotes_ || request_.promote();
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
      records_.push_back(sweepstake::FromProto(record));
      records_.back().is_quarantined = false;  // imports ignore it
      ++collected_count_;
    }
    return absl::OkStatus();
  }

  ServiceContext& context_;
  sessions::AdminLog& admin_;
  std::atomic<size_t>& collected_count_;
  grpc::CallbackServerContext& call_;
  grpc::ByteBuffer& response_;
  const auth::Principal caller_;
  AccessControl::Share transfer_;  // used on the loop, like the next two
  int64_t last_progress_ns_ = 0;
  int64_t deadline_ns_ = sessions::Clock::kNever;
  grpc::ByteBuffer bytes_;
  v1::ImportPriorsRequest request_;
  std::vector<PriorRecord> records_;
  bool promotes_ = false;
  std::vector<priors::SceneKey> new_scenes_;  // new in the store; used by its job, then on the loop
};

bool NamesAny(const v1::SourceFilter& sources) {
  return !sources.source_id().empty() || !sources.build().empty() || sources.token_id() != 0 ||
         sources.unix_from_s() != 0 || sources.unix_until_s() != 0;
}

// Returns the sources that a request selects.
absl::StatusOr<priors::SourceFilter> FilterOf(const v1::SourceFilter& sources,
                                              const auth::Principal& caller) {
  if (sources.token_id() < 0 || sources.unix_from_s() < 0 || sources.unix_until_s() < 0)
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE, "a number of a filter is 0 or more");
  for (const std::string* name : {&sources.project(), &sources.source_id(), &sources.build()}) {
    if (!text::IsOptionalName(*name))
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE, "a name has at most 128 bytes of UTF-8");
  }
  if (absl::Status allowed = CheckProject(caller, sources.project()); !allowed.ok()) return allowed;
  priors::SourceFilter filter{.id = sources.source_id(),
                              .project = sources.project(),
                              .build = sources.build(),
                              .token_id = sources.token_id(),
                              .from_unix_s = static_cast<uint64_t>(sources.unix_from_s())};
  if (sources.unix_until_s() != 0)
    filter.until_unix_s = static_cast<uint64_t>(sources.unix_until_s());
  return filter;
}

// Returns what was done to which evidence, as the rest of a sentence.
template <typename Result>
std::string ChangeText(const char* verb, const Result& result, const v1::SourceFilter& sources) {
  std::string text = absl::StrCat(verb, " ", result.source_count, " sources with ",
                                  result.record_count, " records");
  const auto add = [&text](const char* what, const auto& value) {
    if (value != std::remove_cvref_t<decltype(value)>{})
      absl::StrAppend(&text, ", ", what, " ", value);
  };
  add("project", sources.project());
  add("session", sources.source_id());
  add("build", sources.build());
  add("token", sources.token_id());
  add("begun from Unix time", sources.unix_from_s());
  add("begun until Unix time", sources.unix_until_s());
  return text;
}

// Returns whether a promotion selects a record in quarantine. Imported sources have no token or
// time.
bool IsMeant(const PriorRecord& record, const priors::SourceFilter& filter) {
  return filter.token_id == 0 && filter.from_unix_s == 0 &&
         (filter.id.empty() || filter.id == record.source_id) &&
         (filter.build.empty() || filter.build == record.build);
}

// Adds the records to promote to the quota. In quarantine they did not count.
absl::Status CheckPromotion(priors::PriorStore& store, const priors::SourceFilter& filter,
                            sessions::SceneQuota& quota) {
  priors::ExportPage page;
  do {
    auto next = store.ExportQuarantined({filter.project, ""}, page.next, kRecordsPerMessage);
    if (!next.ok()) return StoreFailed(next.status());
    page = *std::move(next);
    for (const PriorRecord& record : page.records) {
      if (!IsMeant(record, filter)) continue;
      absl::Status status = quota.Add(record.key);
      if (!status.ok()) return status;
    }
  } while (page.records.size() == kRecordsPerMessage);
  return absl::OkStatus();
}

// Serves the pages that load(store, filter, place) reads. The filter is narrowed to what the caller
// may see.
template <typename Stream, typename Load>
auto ServePages(ServiceContext& context, grpc::CallbackServerContext& call, Rpc rpc,
                priors::SceneFilter filter, Load load)
    -> grpc::ServerWriteReactor<decltype(Stream::Page::response)>* {
  const auto caller = context.access.Authorize(call, rpc);
  absl::Status allowed = caller.status();
  if (allowed.ok()) {
    allowed = Narrow(*caller, filter);
    context.access.refusals().TellEnd(CallerOf(call), allowed);
  }
  if (!allowed.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<decltype(Stream::Page::response)>>(
        ToGrpc(allowed, context.counters));
  }
  return Stream::Start(context, call, *caller,
                       [filter, load](priors::PriorReader& store, const auto& place) {
                         return load(store, filter, place);
                       });
}

}  // namespace

grpc::ServerWriteReactor<v1::ExportPriorsResponse>* PriorsService::ExportPriors(
    grpc::CallbackServerContext* call, const v1::ExportPriorsRequest* request) {
  return ServePages<ExportStream>(
      context_, *call, RpcOf("PriorsService/ExportPriors"), {request->project(), request->scene()},
      [quarantined_only = request->quarantined_only(), with_weights = request->with_weights()](
          priors::PriorReader& store, const priors::SceneFilter& filter, TransferPlace place) {
        place.in_quarantine = place.in_quarantine || quarantined_only;
        return LoadRecords(store, filter, place, with_weights);
      });
}

grpc::ServerWriteReactor<v1::CompareBuildsResponse>* PriorsService::CompareBuilds(
    grpc::CallbackServerContext* call, const v1::CompareBuildsRequest* request) {
  return ServePages<ComparisonStream>(
      context_, *call, RpcOf("PriorsService/CompareBuilds"), {request->project(), request->scene()},
      [first = std::make_shared<BuildComparison>(*request)](
          priors::PriorReader& store, const priors::SceneFilter& filter, ComparisonPlace place) {
        if (place.comparison == nullptr) place.comparison = first;
        return LoadComparison(store, filter, place);
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
    auto filter = FilterOf(request->sources(), caller);
    if (!filter.ok()) return end(filter.status());
    if (!NamesAny(request->sources())) {
      return end(Refused(
          v1::ERROR_REASON_INVALID_MESSAGE,
          "name the sources to revoke: by source_id, build, token_id, or a time since 1970"));
    }
    const bool submitted =
        context_.store.Submit([this, request, response, end, filter = *std::move(filter),
                               who = NameAndAddress(caller, *call)](priors::PriorStore& store) {
          LeaderPreview leaders(store, filter.project, request->preview());
          const auto result = store.Revoke(filter, leaders.preview());
          // PostLater, as for commits: earlier results of the store come first.
          context_.loop.PostLater(
              [this, request, response, end, who, result, changes = leaders.Changes()] {
                if (!result.ok()) return end(StoreFailed(result.status()));
                if (!changes.ok()) return end(StoreFailed(changes.status()));
                if (request->preview()) *response->mutable_leader_changes() = *changes;
                response->set_source_count(result->source_count);
                response->set_record_count(result->record_count);
                response->set_window_count(result->window_count);
                if (!request->preview()) {
                  OnChanged(ChangeText("revoked", *result, request->sources()), who);
                  context_.events.Reset();
                }
                end(absl::OkStatus());
              });
        });
    if (!submitted)
      end(Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store has too much to do; try later"));
  });
}

grpc::ServerUnaryReactor* PriorsService::PromotePriors(grpc::CallbackServerContext* call,
                                                       const v1::PromotePriorsRequest* request,
                                                       v1::PromotePriorsResponse* response) {
  constexpr Rpc kRpc = RpcOf("PriorsService/PromotePriors");
  return ServeUnary(context_, *call, kRpc, [&](const auth::Principal& caller, EndCall end) {
    auto filter = FilterOf(request->sources(), caller);
    if (!filter.ok()) return end(filter.status());
    const bool submitted =
        context_.store.Submit([this, request, response, end, filter = *std::move(filter),
                               who = NameAndAddress(caller, *call)](priors::PriorStore& store) {
          sessions::SceneQuota quota(store, context_.options);
          if (const absl::Status allowed = CheckPromotion(store, filter, quota); !allowed.ok())
            return context_.loop.Post([end, allowed] { end(allowed); });
          LeaderPreview leaders(store, filter.project, request->preview());
          const auto result = store.Promote(filter, leaders.preview());
          context_.loop.PostLater([this, request, response, end, who, result,
                                   changes = leaders.Changes(), new_scenes = quota.new_scenes()] {
            if (!request->preview()) OnEvidence(context_, result.status(), new_scenes);
            if (!result.ok()) return end(StoreFailed(result.status()));
            if (!changes.ok()) return end(StoreFailed(changes.status()));
            if (request->preview()) *response->mutable_leader_changes() = *changes;
            response->set_source_count(result->source_count);
            response->set_record_count(result->record_count);
            response->set_window_count(result->window_count);
            response->set_scene_count(result->scene_count);
            if (!request->preview())
              OnChanged(ChangeText("promoted", *result, request->sources()), who);
            end(absl::OkStatus());
          });
        });
    if (!submitted)
      end(Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store has too much to do; try later"));
  });
}

void PriorsService::OnChanged(const std::string& action, const std::string& who) {
  context_.log.warn("{} {}", who, action);
  admin_.Record(who, action);
}

}  // namespace sweepstake::rpc
