#include "server/rpc/rpc_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/impl/server_builder_option.h>
#include <grpcpp/impl/server_builder_plugin.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <spdlog/logger.h>

#include <future>
#include <thread>
#include <utility>

#include "server/history/history.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/connection_listener.h"
#include "server/rpc/services/watch_call.h"

namespace sweepstake::rpc {
namespace {

// Removes the reflection service, which gRPC's library registers with every server when it is
// linked.
class WithoutReflection : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments* /*arguments*/) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    std::erase_if(*plugins,
                  [](const auto& plugin) { return plugin->name() == "proto_server_reflection"; });
  }
};

constexpr int kSecond = 1'000;
constexpr int64_t kHealthIntervalNs = 1'000'000'000;
constexpr int64_t kLossReportIntervalNs = 60'000'000'000;
// longer than the time after which a session repeats a commit
constexpr int64_t kKeepIntervalNs = 5 * kHealthIntervalNs;
constexpr int64_t kMaxSilenceNs =
    10 * kHealthIntervalNs;  // without a beat for this time, the loop counts as unresponsive
constexpr std::chrono::milliseconds kCommitPollInterval{5};
constexpr std::chrono::seconds kEndPatience{1};  // for bytes that clients have not read

void SetLimits(grpc::ServerBuilder& builder, const RpcOptions& options) {
  // Without a quota one connection can make gRPC use a gigabyte of memory.
  grpc::ResourceQuota quota("sweepstaked");
  quota.Resize(options.memory_quota_bytes);
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(static_cast<int>(kMaxMessageBytes));
  // Otherwise gRPC raises its limit of a frame's length, which the guard does not know.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             static_cast<int>(options.max_streams_per_connection));
  const auto add = [&](const char* name, std::chrono::milliseconds time) {
    builder.AddChannelArgument(name, static_cast<int>(time.count()));
  };
  add(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, options.handshake_patience);
  add(GRPC_ARG_KEEPALIVE_TIME_MS, options.keepalive_interval);
  add(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, options.keepalive_patience);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10 * kSecond);
  add(GRPC_ARG_MAX_CONNECTION_IDLE_MS, options.connection_idle_patience);
  add(GRPC_ARG_MAX_CONNECTION_AGE_MS, options.connection_age);
  add(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS, options.connection_age_grace);
}

}  // namespace

RpcServer::RpcServer(RpcOptions options, sessions::LoopClock& clock, priors::AsyncPriorStore& store,
                     spdlog::logger& log)
    : options_(WithRecorder(std::move(options))),
      access_(options_, clock, log),
      events_(store, loop_, sessions_, encoder_),
      sessions_({options_, loop_, store, counters_, events_}),
      recorder_(loop_, sessions_, RecorderOutputs()),
      context_{options_, loop_,   store, counters_, events_, sessions_,
               stalls_,  access_, log,   admin_,    alerts_},
      stalls_(loop_, options_.watcher_patience_ns),
      generic_(context_),
      admin_(options_, loop_, store, counters_),
      alerts_(options_.alerts, loop_, sessions_),
      loop_(clock, options_.on_timer) {}

RpcOptions RpcServer::WithRecorder(RpcOptions options) {
  if (options.history == nullptr) return options;
  options.on_use = [this](const sessions::SessionIdentity& session, sessions::SessionUse use) {
    recorder_.Add(session, std::move(use));
  };
  return options;
}

history::HistoryRecorder::Outputs RpcServer::RecorderOutputs() {
  return {.encode =
              [](const sessions::SceneActivity& activity) {
                v1::ScenePosterior scene;
                ToProto(activity, scene);
                return *std::move(scene.mutable_activity());
              },
          .write = [this](auto batch) { options_.history->Write(std::move(batch)); }};
}

absl::StatusOr<std::unique_ptr<RpcServer>> RpcServer::Start(const std::string& listen,
                                                            RpcOptions options,
                                                            sessions::LoopClock& clock,
                                                            priors::AsyncPriorStore& store,
                                                            spdlog::logger& log) {
  std::unique_ptr<RpcServer> server(new RpcServer(std::move(options), clock, store, log));
  if (absl::Status status = server->Listen(listen); !status.ok()) return status;
  return server;
}

void RpcServer::BindListener(grpc::ServerBuilder& builder) {
  listener_ = std::make_unique<ConnectionListener>(
      builder.experimental().AddExternalConnectionAcceptor(
          grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
          grpc::InsecureServerCredentials()),
      options_, loop_.clock(), counters_, access_.refusals());
}

absl::Status RpcServer::Listen(const std::string& address) {
  // This call is needed even without reflection: it prevents the linker from dropping the library.
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetLimits(builder, options_);
  if (!options_.reflection) builder.SetOption(std::make_unique<WithoutReflection>());
  BindListener(builder);
  generic_.Register(builder);
  server_ = builder.BuildAndStart();
  if (server_ == nullptr) return absl::UnavailableError("gRPC could not start its server");
  if (absl::Status status = listener_->Listen(address); !status.ok()) return status;
  port_ = listener_->port();
  last_beat_ns_ = loop_.clock().NowNs();
  loop_.Post([this] { WatchStore(); });
  loop_.Post([this] {
    if (const absl::Status restored = alerts_.Start(); !restored.ok())
      context_.log.error("the silences of alerts cannot be read, and there are none now: {}",
                         std::string(restored.message()));
  });
  return absl::OkStatus();
}

bool RpcServer::CallOverHttp(ServedCall call, const std::optional<std::string>& token) {
  if (!drained_) return BeginHttpCall(context_, std::move(call), token);
  call.on_end(Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; try again later"));
  return true;
}

bool RpcServer::WatchOverHttp(const google::protobuf::Message& request, const std::string& peer,
                              std::optional<std::string_view> token,
                              std::shared_ptr<events::Sink> sink) {
  std::optional<events::Wish> wish = WishOf(request);
  if (!wish) return false;
  wish->snapshots = true;
  wish->on_end = [this, peer](const absl::Status& status) {
    access_.refusals().TellEnd(peer, status);
    CountError(status, counters_);
  };
  auto caller = access_.AuthorizeOverHttp(peer, token, RpcOf(wish->kind));
  loop_.Post([this, wish = *std::move(wish), sink = std::move(sink), caller = std::move(caller)] {
    if (caller.ok()) return BeginWatch(context_, wish, *caller, *sink);
    CountError(caller.status(), counters_);
    sink->OnEnd(caller.status());
  });
  return true;
}

RpcServer::~RpcServer() {
  Drain(std::chrono::milliseconds(0));
  server_.reset();
}

void RpcServer::Adjust(const RpcOptions& options) {
  options_.keeps_audit = options.keeps_audit;
  options_.max_time_scale = options.max_time_scale;
  options_.max_sessions = options.max_sessions;
  options_.max_sessions_per_party = options.max_sessions_per_party;
  options_.max_streams_per_address = options.max_streams_per_address;
  options_.max_projects = options.max_projects;
  options_.max_scenes = options.max_scenes;
  options_.max_messages_per_s = options.max_messages_per_s;
  options_.max_hellos_per_s = options.max_hellos_per_s;
  options_.max_reads_per_s = options.max_reads_per_s;
  options_.max_transfers = options.max_transfers;
  options_.max_transfers_per_token = options.max_transfers_per_token;
  options_.resume_window_ns = options.resume_window_ns;
  options_.max_watchers = options.max_watchers;
  options_.alerts.max_metric_scenes = options.alerts.max_metric_scenes;
}

bool RpcServer::responsive() const {
  return context_.loop.clock().NowNs() - last_beat_ns_ < kMaxSilenceNs;
}

void RpcServer::WatchStore() {
  last_beat_ns_ = loop_.clock().NowNs();
  access_.refusals().TellLeftOut();
  if (!draining_) {
    UpdateHealth();
    ReportLosses();
    EndRefused();
    admin_.Retry();
    FollowOthers();
    KeepWaiting();
  }
  loop_.PostAt(last_beat_ns_ + kHealthIntervalNs, [this] { WatchStore(); });
}

void RpcServer::FollowOthers() {
  if (!options_.shares_store || !context_.store.healthy() || following_) return;
  following_ = context_.store.Submit([this](priors::PriorStore& store) {
    loop_.Post([this, changed = store.TakeChangedScenes()] {
      following_ = false;
      if (!changed.ok()) return;  // the next call returns these scenes again
      for (const priors::SceneKey& scene : *changed) events_.Reload(scene);
    });
  });
}

void RpcServer::EndRefused() {
  if (!access_.asks_for_tokens()) return;
  generic_.telemetry().EndRefused();
  events_.EndRefused();
}

void RpcServer::UpdateHealth() {
  if (context_.store.healthy() == serving_) return;
  serving_ = !serving_;
  generic_.health().Set(serving_);
  if (serving_) {
    context_.log.info("the prior store can be written and read again");
  } else {
    context_.log.error(
        "the prior store cannot be written, or a read does not finish: decisions continue in "
        "memory, and only messages on disk are acknowledged");
  }
}

void RpcServer::ReportLosses() {
  const priors::StoreLosses by_store = context_.store.losses();
  counters_.lost_audit_row_count +=
      by_store.audit_row_count - std::exchange(lost_by_store_, by_store.audit_row_count);
  counters_.limited_player_evidence_count = by_store.player_increment_count;
  const int64_t now_ns = last_beat_ns_;
  const uint64_t rows = counters_.lost_audit_row_count;
  const uint64_t limited = by_store.player_increment_count;
  const bool is_new = rows > reported_lost_rows_ || limited > reported_limited_;
  if (!is_new || now_ns < next_loss_report_ns_) return;
  if (rows > reported_lost_rows_)
    context_.log.warn(
        "{} rows of the audit log could not be written, {} since the start: later decisions of "
        "these sessions cannot be replayed from the log",
        rows - reported_lost_rows_, rows);
  if (limited > reported_limited_)
    context_.log.warn(
        "{} records of players were not stored, or without their regime, {} since the start (the "
        "latest: {}): a party of players may add {} machine classes to a scene, and players "
        "regimes until it has {}; play such a scene with a token of the role ingest to add more",
        limited - reported_limited_, limited, by_store.example, priors::kMaxScenesOfParty,
        priors::kMaxRegimesOfPlayers);
  reported_lost_rows_ = rows;
  reported_limited_ = limited;
  next_loss_report_ns_ = now_ns + kLossReportIntervalNs;
}

void RpcServer::KeepWaiting() {
  if (!options_.keep_waiting) return;
  const int64_t now_ns = loop_.clock().NowNs();
  const bool is_away = !context_.store.healthy();
  if (is_away) away_at_ns_ = now_ns;
  // A store that has recovered needs up to kKeepIntervalNs to commit the waiting updates. After
  // that time, pass the updates that still wait to keep_waiting once more.
  const bool is_due =
      is_away ? now_ns >= keep_at_ns_ : is_kept_ && now_ns - away_at_ns_ >= kKeepIntervalNs;
  if (!is_due) return;
  is_kept_ = is_away;
  keep_at_ns_ = now_ns + kKeepIntervalNs;
  options_.keep_waiting(Waiting());
}

std::vector<priors::SourceUpdate> RpcServer::Waiting() const {
  std::vector<priors::SourceUpdate> updates = sessions_.Waiting();
  admin_.AppendWaiting(updates);
  return updates;
}

void RpcServer::Drain(std::chrono::milliseconds patience) {
  if (server_ == nullptr || drained_.exchange(true)) return;
  const auto deadline = std::chrono::steady_clock::now() + patience;
  generic_.health().ShutDown();
  RunOnLoop([this] {
    draining_ = true;
    alerts_.Stop();
    generic_.telemetry().Drain();
    events_.Drain();
    sessions_.RetryCommits();
    admin_.Retry();
  });
  listener_->StopAccepting();
  server_->Shutdown(std::chrono::system_clock::now() + patience);
  server_->Wait();
  listener_->AwaitEnd(kEndPatience);
  listener_.reset();
  AwaitCommits(deadline);
  RunOnLoop([this] { recorder_.Finish(); });
  if (options_.keep_waiting) RunOnLoop([this] { options_.keep_waiting(Waiting()); });
}

sessions::HeldEvidence RpcServer::CountHeld() {
  std::promise<sessions::HeldEvidence> held;
  // The results of the store are also posted with PostLater, so earlier results run before this
  // task.
  loop_.PostLater([&] { held.set_value(sessions_.CountHeld()); });
  return held.get_future().get();
}

void RpcServer::RunOnLoop(const std::function<void()>& task) {
  std::promise<void> done;
  loop_.Post([&] {
    task();
    done.set_value();
  });
  done.get_future().wait();
}

void RpcServer::AwaitCommits(std::chrono::steady_clock::time_point deadline) {
  bool committing = true;
  while (committing && std::chrono::steady_clock::now() < deadline) {
    RunOnLoop([&] { committing = sessions_.committing() || admin_.committing(); });
    if (committing) std::this_thread::sleep_for(kCommitPollInterval);
  }
}

}  // namespace sweepstake::rpc
