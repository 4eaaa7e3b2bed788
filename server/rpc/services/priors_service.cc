#include "server/rpc/services/priors_service.h"

#include <spdlog/logger.h>

#include <algorithm>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/pooling/priors_diff.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/text/counts.h"
#include "engine_client/text/names.h"
#include "server/auth/ticket.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/leader_preview.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/scene_quota.h"
#include "server/sessions/session_table.h"
#include "server/sessions/source_weights.h"

namespace sweepstake::rpc {
namespace {

using priors::PriorRecord;

// The position in an export, which sends first the evidence that counts and then the records in
// quarantine.
struct TransferPlace {
  bool in_quarantine = false;
  priors::ExportPlace after = {};
};

absl::StatusOr<StreamPage> LoadRecords(priors::PriorReader& store,
                                       const priors::SceneFilter& filter, TransferPlace& place,
                                       bool with_weights) {
  const auto stored = place.in_quarantine
                          ? store.ExportQuarantined(filter, place.after, kRecordsPerMessage)
                          : store.Export(filter, place.after, kRecordsPerMessage);
  if (!stored.ok()) return stored.status();
  const bool ends = stored->records.size() < kRecordsPerMessage;
  const bool last = ends && place.in_quarantine;
  place = ends ? TransferPlace{.in_quarantine = true}
               : TransferPlace{place.in_quarantine, stored->next};
  if (stored->records.empty())
    return last ? StreamPage{} : LoadRecords(store, filter, place, with_weights);
  const auto response = std::make_shared<v1::ExportPriorsResponse>();
  sessions::SourceWeights weights(store);
  for (const PriorRecord& record : stored->records) {
    v1::PriorRecord& message = *response->add_records();
    message = ToProto(record);
    if (!with_weights) continue;
    const auto weight = weights.Of(record);
    if (!weight.ok()) return weight.status();
    message.set_weight(*weight);
  }
  return StreamPage{.response = response, .last = last};
}

bool IsChosen(const v1::BuildChoice& choice, const std::string& build) {
  return !choice.has_build() || (choice.build() == build) != choice.others();
}

// Groups the evidence of the chosen builds as if it all came from one build.
decision::PriorsGroups GroupsOf(const v1::BuildChoice& choice,
                                const std::vector<PriorRecord>& sums) {
  std::vector<PriorRecord> chosen;
  for (const PriorRecord& sum : sums) {
    if (!IsChosen(choice, sum.build)) continue;
    chosen.push_back(sum);
    chosen.back().build.clear();
  }
  return decision::GroupPriors(chosen);
}

// Adds the names of the builds with evidence of the scene. The build with the most recent evidence
// comes first.
void AddBuilds(const std::vector<PriorRecord>& sums, v1::SceneComparison& scene) {
  std::map<std::string, uint64_t> last_seen;  // by build
  for (const PriorRecord& sum : sums) {
    if (sum.key.machine_class != scene.machine_class() ||
        sum.key.reward_version != scene.reward_version())
      continue;
    uint64_t& seen = last_seen[sum.build];
    seen = std::max(seen, sum.last_seen_unix_s);
  }
  std::vector<std::pair<std::string, uint64_t>> builds(last_seen.begin(), last_seen.end());
  std::stable_sort(builds.begin(), builds.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  for (auto& [build, seen] : builds) scene.add_builds(std::move(build));
}

// Compares the evidence of two choices of builds, scene by scene.
class BuildComparison {
 public:
  explicit BuildComparison(v1::CompareBuildsRequest request) : request_(std::move(request)) {}

  // Adds a record that is not in quarantine. If it begins a new scene, appends the comparison of
  // the previous scene to the response. REQUIRES: the records of a scene follow one another.
  void Add(PriorRecord record, v1::CompareBuildsResponse& response) {
    if (record.key.scene != scene_.scene || record.key.project != scene_.project) {
      EndScene(response);
      scene_ = record.key;
    }
    if (!request_.scene().empty()) record.key.regime.clear();
    sums_.Add(std::move(record));
  }

  // Appends the comparison of the current scene to the response.
  void EndScene(v1::CompareBuildsResponse& response) {
    const std::vector<PriorRecord> sums = std::exchange(sums_, {}).Take();
    const decision::PriorsGroups before = GroupsOf(request_.before(), sums);
    const decision::PriorsGroups after = GroupsOf(request_.after(), sums);
    for (const decision::SceneComparison& scene : decision::ComparePriors(before, after)) {
      if (request_.changes_only() && !scene.changed()) continue;
      v1::SceneComparison& message = *response.add_scenes();
      ToProto(scene, /*with_intervals=*/!request_.scene().empty(), message);
      AddBuilds(sums, message);
    }
  }

 private:
  const v1::CompareBuildsRequest request_;
  BuildSums sums_;  // evidence of the current scene
  EvidenceKey scene_;
};

absl::StatusOr<StreamPage> LoadComparison(priors::PriorReader& store,
                                          const priors::SceneFilter& filter,
                                          priors::ExportPlace& place, BuildComparison& comparison) {
  auto stored = store.Export(filter, place, kRecordsPerMessage);
  if (!stored.ok()) return stored.status();
  place = stored->next;
  const bool last = stored->records.size() < kRecordsPerMessage;
  const auto response = std::make_shared<v1::CompareBuildsResponse>();
  for (PriorRecord& record : stored->records) comparison.Add(std::move(record), *response);
  if (last) comparison.EndScene(*response);
  return StreamPage{.response = response, .last = last};
}

// Called with the result of an import, a promotion or a revocation.
void OnEvidence(ServiceContext& context, const absl::Status& status,
                const std::vector<priors::SceneKey>& new_scenes) {
  // If the result is UNAVAILABLE, the store may have applied the change nevertheless.
  if (status.ok() || absl::IsUnavailable(status)) context.events.Reset();
  if (!status.ok()) return;
  // The scenes are in the store now. If sessions hold them, NewScenes would count them
  // again.
  for (const priors::SceneKey& scene : new_scenes) context.sessions.new_scenes().Forget(scene);
}

// One import. gRPC's callbacks parse and check one message at a time and post to the decision loop.
// Everything else runs on the loop, except the job on the store's writing thread.
class PriorImport final : public grpc::ServerGenericBidiReactor, public Transfer {
 public:
  // `collected_count` counts the records that all imports together hold in memory.
  PriorImport(ServiceContext& context, std::atomic<size_t>& collected_count,
              grpc::CallbackServerContext& call, Caller caller)
      : Transfer(context, std::move(caller)), collected_count_(collected_count), call_(call) {
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
  void OnStalled() override {
    const absl::Status stalled =
        Refused(v1::ERROR_REASON_CALL_STALLED,
                "the records did not arrive in time; nothing was imported; import them again");
    EndTransfer(stalled);
    Cancel(call_, ToGrpc(stalled, context_.counters));
  }

 private:
  void Begin() {
    const absl::Status begun = BeginTransfer(v1::ERROR_REASON_TOO_MANY_IMPORTS);
    begun.ok() ? ReadNext() : End(begun);
  }

  // Reads the next message. Ends the import if the caller's token was revoked or has expired since
  // the last one.
  void ReadNext() {
    if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
      return End(still);
    OnProgress();
    StartRead(&bytes_);
  }

  void OnHalfClose() {
    // A lost connection must not count as the orderly end of the import.
    if (call_.IsCancelled())
      return End(
          absl::CancelledError("the stream ended before its last record; nothing was imported"));
    if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
      return End(still);
    WaitForStore();
    const bool submitted = context_.store.Submit([this](priors::PriorStore& store) {
      if (const absl::Status allowed = CheckQuota(store); !allowed.ok())
        return context_.loop.Post([this, allowed] { End(allowed); });
      const auto result =
          promotes_ ? store.Import(records_) : store.Quarantine(records_, kMaxQuarantinedRecords);
      // PostLater, as for the results of commits, so that earlier results are applied first.
      context_.loop.PostLater([this, result] { OnImported(result); });
    });
    if (!submitted) End(StoreBusy());
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
    const std::string action = absl::StrCat(
        "imported ", text::Counted(records_.size(), "record"), ", ", result->applied_count,
        " of them new or newer, which ", promotes_ ? "count at once" : "wait in quarantine");
    context_.log.info("{} {}", NameForLog(caller_), action);
    context_.admin.Record(NameAndAddress(caller_), action);
    End(absl::OkStatus());
  }

  void End(const absl::Status& status) {
    EndTransfer(status);
    const grpc::Status end = ToGrpc(status, context_.counters);
    status.ok() ? StartWriteAndFinish(&response_, {}, end) : Finish(end);
  }

  absl::Status Take() {
    if (!Parse(bytes_, request_)) {
      ++context_.counters.malformed_message_count;
      return Refused(v1::ERROR_REASON_MALFORMED_MESSAGE,
                     "a message does not parse as sweepstake.v1.ImportPriorsRequest");
    }
    if (request_.records_size() > static_cast<int>(kRecordsPerMessage)) {
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                     absl::StrCat("a message may hold at most ", kRecordsPerMessage, " records"));
    }
    promotes_ = promotes_ || request_.promote();
    for (const v1::PriorRecord& record : request_.records()) {
      if (records_.size() == kMaxImportRecords) {
        return Refused(
            v1::ERROR_REASON_IMPORT_TOO_LARGE,
            absl::StrCat("an import may hold at most ", kMaxImportRecords, " records; split it"));
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
      records_.back().is_quarantined = false;  // an import ignores this field
      ++collected_count_;
    }
    return absl::OkStatus();
  }

  std::atomic<size_t>& collected_count_;
  grpc::CallbackServerContext& call_;
  grpc::ByteBuffer response_;
  grpc::ByteBuffer bytes_;
  v1::ImportPriorsRequest request_;
  std::vector<PriorRecord> records_;
  bool promotes_ = false;
  // Scenes that the import adds to the store; set by the store's job, then used on the loop.
  std::vector<priors::SceneKey> new_scenes_;
};

// Returns whether there is a filter besides the project. Otherwise a forgotten one could revoke a
// whole project or daemon.
bool NamesAny(v1::SourceFilter sources) {
  sources.clear_project();
  return sources.ByteSizeLong() > 0;
}

// Returns the store's filter for the sources that the request selects.
absl::StatusOr<priors::SourceFilter> FilterOf(const v1::SourceFilter& sources,
                                              const auth::Principal& caller) {
  // A filter that this version does not know must not be ignored: more would be selected.
  if (!sources.GetReflection()->GetUnknownFields(sources).empty())
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "this daemon does not know a field of the filter; update it");
  if (sources.token_id() < 0 || sources.unix_from_s() < 0 || sources.unix_until_s() < 0)
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "the numbers of a filter must not be negative");
  for (const std::string* name : {&sources.project(), &sources.source_id(), &sources.build()}) {
    if (!text::IsOptionalName(*name))
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                     "a name must have at most 128 bytes of UTF-8 and no control characters");
  }
  if (!sources.player().empty() && !auth::IsPlayer(sources.player())) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "a player has 1 to 64 letters, digits, '-' and '_', as in its ticket");
  }
  std::string network;
  if (!sources.network().empty()) {
    const auto named = net::NetworkNamed(sources.network());
    if (!named) {
      return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                     "a network is an address such as 203.0.113.7 or 2001:db8::1, or a network "
                     "such as 203.0.113.0/24 or 2001:db8::/48");
    }
    network = *named;
  }
  if (absl::Status allowed = CheckProject(caller, sources.project()); !allowed.ok()) return allowed;
  priors::SourceFilter filter{.id = sources.source_id(),
                              .project = sources.project(),
                              .build = sources.build(),
                              .token_id = sources.token_id(),
                              .player = sources.player(),
                              .network = network,
                              .from_unix_s = static_cast<uint64_t>(sources.unix_from_s())};
  if (sources.unix_until_s() != 0)
    filter.until_unix_s = static_cast<uint64_t>(sources.unix_until_s());
  return filter;
}

// Describes a promotion or revocation for the log, as the rest of a sentence whose subject is the
// caller.
std::string ChangeText(const char* verb, const priors::ChangeResult& result,
                       const v1::SourceFilter& sources) {
  std::string text = absl::StrCat(verb, " ", text::Counted(result.source_count, "source"), " with ",
                                  text::Counted(result.record_count, "record"));
  const auto add = [&text](const char* what, const auto& value) {
    if (value != std::remove_cvref_t<decltype(value)>{})
      absl::StrAppend(&text, ", ", what, " ", value);
  };
  add("project", sources.project());
  add("session", sources.source_id());
  add("build", sources.build());
  add("token", sources.token_id());
  add("player", sources.player());
  add("network", sources.network());
  add("started at or after Unix time", sources.unix_from_s());
  add("started at or before Unix time", sources.unix_until_s());
  return text;
}

// Returns whether a promotion with this filter selects the record in quarantine. A filter by token
// player, network or start time selects nothing, because imported sources have none of these.
bool IsMeant(const PriorRecord& record, const priors::SourceFilter& filter) {
  return filter.token_id == 0 && filter.player.empty() && filter.network.empty() &&
         filter.from_unix_s == 0 && (filter.id.empty() || filter.id == record.source_id) &&
         (filter.build.empty() || filter.build == record.build);
}

// Checks whether the quota allows the records that a promotion selects. Records in quarantine do
// not count against the quota.
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

// Returns the filter of a request, restricted to the projects that the caller may see.
template <typename Request>
absl::StatusOr<priors::SceneFilter> ScenesOf(const Caller& caller, const Request& request) {
  priors::SceneFilter filter{request.project(), request.scene()};
  if (absl::Status allowed = Narrow(caller, filter); !allowed.ok()) return allowed;
  return filter;
}

// Revokes or promotes sources: runs the change, or previews it, on the store's writing thread.
template <typename Request, typename Response>
void ChangeSources(ServiceContext& context, const Caller& caller, const Request& request,
                   Response& response, const EndCall& end) {
  constexpr bool kPromotes = std::is_same_v<Request, v1::PromotePriorsRequest>;
  auto selected = FilterOf(request.sources(), caller);
  if (!selected.ok()) return end(selected.status());
  if (!kPromotes && !NamesAny(request.sources())) {
    return end(
        Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                "select the sessions to revoke by source, build, token, player, network or time"));
  }
  const auto change = [&context, &request, &response, caller, end,
                       filter = *std::move(selected)](priors::PriorStore& store) {
    sessions::SceneQuota quota(store, context.options);
    if (kPromotes) {
      if (const absl::Status allowed = CheckPromotion(store, filter, quota); !allowed.ok())
        return context.loop.Post([end, allowed] { end(allowed); });
    }
    LeaderPreview leaders(store, filter.project, request.preview());
    const auto result = kPromotes ? store.Promote(filter, leaders.preview())
                                  : store.Revoke(filter, leaders.preview());
    // PostLater, as for the results of commits, so that earlier results are applied first.
    context.loop.PostLater([&context, &request, &response, caller, end, result,
                            changes = leaders.Changes(), new_scenes = quota.new_scenes()] {
      if (!request.preview()) OnEvidence(context, result.status(), new_scenes);
      if (!result.ok()) return end(StoreFailed(result.status()));
      if (!changes.ok()) return end(StoreFailed(changes.status()));
      response.set_source_count(result->source_count);
      response.set_record_count(result->record_count);
      response.set_window_count(result->window_count);
      if constexpr (kPromotes) response.set_scene_count(result->scene_count);
      if (request.preview()) {
        *response.mutable_leader_changes() = *changes;
      } else {
        const std::string who = NameAndAddress(caller);
        const std::string action =
            ChangeText(kPromotes ? "promoted" : "revoked", *result, request.sources());
        context.log.warn("{} {}", who, action);
        context.admin.Record(who, action);
      }
      end(absl::OkStatus());
    });
  };
  if (!context.store.Submit(change)) end(StoreBusy());
}

}  // namespace

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::ExportPriorsRequest& request) {
  auto filter = ScenesOf(caller, request);
  if (!filter.ok()) return filter.status();
  return LoadPage([filter = *std::move(filter),
                   place = TransferPlace{.in_quarantine = request.quarantined_only()},
                   with_weights = request.with_weights()](priors::PriorReader& store) mutable {
    return LoadRecords(store, filter, place, with_weights);
  });
}

absl::StatusOr<LoadPage> PagesOf(const Caller& caller, const v1::CompareBuildsRequest& request) {
  auto filter = ScenesOf(caller, request);
  if (!filter.ok()) return filter.status();
  return LoadPage([filter = *std::move(filter), place = priors::ExportPlace(),
                   comparison = std::make_shared<BuildComparison>(request)](
                      priors::PriorReader& store) mutable {
    return LoadComparison(store, filter, place, *comparison);
  });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::RevokePriorsRequest& request,
            v1::RevokePriorsResponse& response, const EndCall& end) {
  ChangeSources(context, caller, request, response, end);
}

void Answer(ServiceContext& context, const Caller& caller, const v1::PromotePriorsRequest& request,
            v1::PromotePriorsResponse& response, const EndCall& end) {
  ChangeSources(context, caller, request, response, end);
}

grpc::ServerGenericBidiReactor* PriorImports::Serve(grpc::CallbackServerContext& call,
                                                    Caller caller) {
  return new PriorImport(context_, collected_count_, call, std::move(caller));
}

}  // namespace sweepstake::rpc
