// The gRPC side of the daemon, which listens, serves and drains. grpc.health.v1 reports NOT_SERVING
// while the store cannot write and after a drain has begun.
//
// Thread-safe, except that one thread calls Drain. It owns the decision loop and the sessions; the
// clock, the store and the log are borrowed. The owner ends it in this order: it calls Drain,
// closes the store (whose callbacks still use the loop), destroys this object, and then destroys
// the store.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/common/access_control.h"
#include "server/rpc/services/audit_service.h"
#include "server/rpc/services/posteriors_service.h"
#include "server/rpc/services/priors_service.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/sessions_service.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/rpc/services/telemetry_service.h"
#include "server/rpc/services/watcher_set.h"
#include "server/sessions/admin_log.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/session_table.h"
#include "server/watch/watch_hub.h"

namespace sweepstake::rpc {

class ConnectionListener;

class RpcServer {
 public:
  // `listen` is HOST:PORT; port 0 means any free port. It serves plain text unless the options name
  // a certificate; the caller has checked that this is wanted. Errors: UNAVAILABLE (cannot listen
  // there), INVALID_ARGUMENT (the files of TLS cannot be used).
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::string& listen,
                                                          RpcOptions options,
                                                          sessions::Clock& clock,
                                                          priors::AsyncPriorStore& store,
                                                          spdlog::logger& log);
  ~RpcServer();

  int port() const { return port_; }
  const Counters& counters() const { return counters_; }
  // Writes what somebody did to the audit log. Any thread may call it.
  void RecordAction(std::string action, std::string who) {
    admin_.Record(std::move(action), std::move(who));
  }
  // Calls through it name in the metadata kCallerKey for whom they are. It may outlive the server,
  // and then they are UNAVAILABLE.
  const std::shared_ptr<grpc::Channel>& own_channel() const { return own_channel_; }
  // Who speaks HTTP, as AccessControl says. Any thread may ask.
  absl::StatusOr<auth::Principal> IdentifyOverHttp(const std::string& caller,
                                                   std::optional<std::string_view> token) {
    return access_.IdentifyOverHttp(caller, token);
  }
  bool asks_over_http() const { return access_.asks_over_http(); }
  // Takes over the options that are Adjustable. Any thread may call it.
  void Adjust(const RpcOptions& options);
  // Returns whether the decision loop has run within ten seconds. Any thread may ask.
  bool responsive() const;

  // Refuses new streams, tells clients to reconnect later, waits for pending writes, and ends.
  // Calls that are not done within `patience` are cancelled. Idempotent.
  void Drain(std::chrono::milliseconds patience);
  // Returns what is not on disk, as the store's answers so far say. Must not be called on the loop.
  sessions::HeldEvidence CountHeld();

 private:
  RpcServer(RpcOptions options, sessions::Clock& clock, priors::AsyncPriorStore& store,
            spdlog::logger& log);
  absl::Status Listen(const std::string& address);
  // Starts the services a second time, for the daemon itself.
  absl::Status ServeOneself();
  void Register(grpc::ServerBuilder& builder);
  // Makes the listener, whose connections the server of this builder will serve.
  void BindListener(grpc::ServerBuilder& builder,
                    const std::shared_ptr<grpc::ServerCredentials>& credentials);
  // Runs on the loop once per second, which shows that the loop runs.
  void WatchStore();
  // Ends the long streams of callers whose tokens were revoked or have expired.
  void EndRefused();
  // Where other daemons write the store, too: reads what they have changed of what is watched here.
  void FollowOthers();
  // A store that cannot write or read is not healthy.
  void UpdateHealth();
  void ReportLostAuditRows();
  // While the store cannot be written: lets what waits for it be kept elsewhere.
  void KeepWaiting();
  // Returns what waits for the store, as it is to be committed.
  std::vector<priors::SourceUpdate> Waiting() const;
  // Runs `task` on the loop and waits for it. Must not be called on the loop.
  void RunOnLoop(const std::function<void()>& task);
  // Waits for pending commits, including those of sessions without a client.
  void AwaitCommits(std::chrono::steady_clock::time_point deadline);

  RpcOptions options_;
  Counters counters_;
  AccessControl access_;
  watch::WatchHub watch_hub_;
  sessions::SessionTable sessions_;
  ServiceContext context_;  // also refers to members below
  WatcherSet watchers_;
  StallSweep stalls_;
  TelemetryService telemetry_;
  sessions::AdminLog admin_;
  PosteriorsService posteriors_;
  PriorsService priors_;
  AuditService audit_;
  SessionsService sessions_service_;
  std::atomic<int64_t> last_beat_ns_{0};  // when the loop last looked at the store
  bool serving_ = true;                   // the state of health; used on the loop
  bool draining_ = false;                 // used on the loop
  bool following_ = false;                // the store has been asked; used on the loop
  uint64_t lost_by_store_ = 0;            // audit rows that are counted; used on the loop
  uint64_t reported_lost_rows_ = 0;       // used on the loop
  int64_t next_loss_report_ns_ = 0;       // used on the loop
  int64_t away_at_ns_ = 0;                // when the store was away last; used on the loop
  int64_t keep_at_ns_ = 0;                // while it is away; used on the loop
  bool is_kept_ = false;                  // something may be kept; used on the loop
  std::shared_ptr<grpc::Channel> own_channel_;
  bool drained_ = false;  // used by Drain's caller
  // The loop is declared after everything that its tasks use, since its destructor runs the last
  // ones.
  sessions::DecisionLoop loop_;
  std::unique_ptr<grpc::Server> server_;
  // Nobody but the daemon reaches it, so that no limit of a connection holds here.
  std::unique_ptr<grpc::Server> own_server_;
  std::unique_ptr<ConnectionListener> listener_;
  int port_ = 0;
};

}  // namespace sweepstake::rpc
