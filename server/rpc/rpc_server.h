// The gRPC server of the daemon: it accepts connections, serves calls, and drains before the daemon
// stops. grpc.health.v1 reports NOT_SERVING while the store cannot be written, and after a drain
// has begun.
//
// Thread-safe, except that only one thread may call Drain. It owns the decision loop and the
// sessions; the clock, the store and the log are borrowed. The owner shuts it down in this order:
// call Drain, close the store (whose callbacks still use the loop), destroy this object, destroy
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
#include "server/alerts/alert_monitor.h"
#include "server/events/event_bus.h"
#include "server/history/history_recorder.h"
#include "server/rpc/common/access_control.h"
#include "server/rpc/common/event_encoder.h"
#include "server/rpc/generic_service.h"
#include "server/rpc/services/served_methods.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/sessions/admin_log.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {

class ConnectionListener;

class RpcServer {
 public:
  // `listen` is HOST:PORT; port 0 means any free port. The server uses plain text unless the
  // options name a certificate; the caller has checked that plain text is allowed. Errors:
  // UNAVAILABLE (cannot listen there), INVALID_ARGUMENT (the TLS files cannot be used).
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::string& listen,
                                                          RpcOptions options,
                                                          sessions::LoopClock& clock,
                                                          priors::AsyncPriorStore& store,
                                                          spdlog::logger& log);
  ~RpcServer();

  int port() const { return port_; }
  const Counters& counters() const { return counters_; }
  // Writes an action to the audit log. `who` is the subject of a sentence, and `action` is the rest
  // of it. If `who` is empty, `action` is the whole sentence. Any thread may call it.
  void RecordAction(std::string who, std::string action) {
    admin_.Record(std::move(who), std::move(action));
  }
  // Returns the figures for metrics. Any thread may call it.
  std::shared_ptr<const alerts::AlertFigures> alert_figures() const { return alerts_.figures(); }
  // Begins a call for an HTTP request (BeginHttpCall). Once Drain has begun, calls are UNAVAILABLE.
  bool CallOverHttp(ServedCall call, const std::optional<std::string>& token);
  // Identifies the caller of an HTTP request by its token, whatever the role of the token. Any
  // thread may call it.
  absl::StatusOr<auth::Principal> IdentifyOverHttp(const std::string& peer,
                                                   std::optional<std::string_view> token) {
    return access_.AuthorizeOverHttp(peer, token, std::nullopt);
  }
  // Begins a watch for an HTTP request. Returns false if the message is not a request of a Watch
  // method. The sink must take the initial state with Subscriber::TakeSnapshot. It is used on the
  // decision loop. Any thread may call it.
  bool WatchOverHttp(const google::protobuf::Message& request, const std::string& peer,
                     std::optional<std::string_view> token, std::shared_ptr<events::Sink> sink);
  sessions::DecisionLoop& loop() { return loop_; }
  bool asks_over_http() const { return access_.asks_over_http(); }
  // Sets the Adjustable options. Any thread may call it.
  void Adjust(const RpcOptions& options);
  // Returns whether the decision loop has run within the last ten seconds. Any thread may call it.
  bool responsive() const;

  // Refuses new streams, requests clients to reconnect later, waits for pending commits, and ends.
  // Calls that have not finished within `patience` are cancelled. Idempotent.
  void Drain(std::chrono::milliseconds patience);
  // Counts the sessions whose evidence is not on disk, after the store's results so far have been
  // applied. Must not be called on the loop.
  sessions::HeldEvidence CountHeld();

 private:
  RpcServer(RpcOptions options, sessions::LoopClock& clock, priors::AsyncPriorStore& store,
            spdlog::logger& log);
  absl::Status Listen(const std::string& address);
  // Creates listener_. The gRPC server that `builder` builds later serves its connections.
  void BindListener(grpc::ServerBuilder& builder);
  // Runs on the loop once per second: checks the store, the tokens and the waiting updates.
  // responsive() checks when it ran last.
  void WatchStore();
  // Ends the telemetry streams and watches of callers whose tokens were revoked or have expired.
  void EndRefused();
  // If other daemons write to the same store, reloads the watched scenes that they have changed.
  void FollowOthers();
  // Reports NOT_SERVING while the store cannot be written or read.
  void UpdateHealth();
  void ReportLosses();
  // Calls options_.keep_waiting when it is due (rpc/common/options.h).
  void KeepWaiting();
  // Returns the options, with the recorder as the receiver of what sessions ran.
  RpcOptions WithRecorder(RpcOptions options);
  history::HistoryRecorder::Outputs RecorderOutputs();
  // Returns the updates that the store has not written yet.
  std::vector<priors::SourceUpdate> Waiting() const;
  // Runs `task` on the loop and waits for it. Must not be called on the loop.
  void RunOnLoop(const std::function<void()>& task);
  // Waits for pending commits, including those of sessions without a client.
  void AwaitCommits(std::chrono::steady_clock::time_point deadline);

  RpcOptions options_;
  Counters counters_;
  AccessControl access_;
  const EventEncoder encoder_;
  events::EventBus events_;
  sessions::SessionTable sessions_;
  history::HistoryRecorder recorder_;  // used on the loop
  ServiceContext context_;             // also refers to members declared below
  StallSweep stalls_;
  GenericService generic_;
  sessions::AdminLog admin_;
  alerts::AlertMonitor alerts_;
  std::atomic<int64_t> last_beat_ns_{0};  // when the loop last ran WatchStore
  bool serving_ = true;                   // the reported health; used on the loop
  bool draining_ = false;                 // used on the loop
  bool following_ = false;                // whether TakeChangedScenes is running; used on the loop
  uint64_t lost_by_store_ = 0;       // rows lost by the store and already counted; used on the loop
  uint64_t reported_lost_rows_ = 0;  // used on the loop
  uint64_t reported_limited_ = 0;    // limited records of players; used on the loop
  int64_t next_loss_report_ns_ = 0;  // used on the loop
  int64_t away_at_ns_ = 0;           // when the store was last unhealthy; used on the loop
  int64_t keep_at_ns_ = 0;           // next call of keep_waiting; used on the loop
  // Whether the last call of keep_waiting was made while the store was unhealthy; used on the loop.
  bool is_kept_ = false;
  std::atomic<bool> drained_ = false;
  // The loop is declared after everything that its tasks use, because its destructor runs the last
  // tasks.
  sessions::DecisionLoop loop_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<ConnectionListener> listener_;
  int port_ = 0;
};

}  // namespace sweepstake::rpc
