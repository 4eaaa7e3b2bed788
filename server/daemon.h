// The daemon: connects the prior store, the gRPC server, the HTTP server and the program's log. The
// program runs one; a test may start several in its own process.
//
// Thread-safe, except that Drain and the destructor must be called by one thread. The clock must
// outlive the daemon.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/alerts/webhook.h"
#include "server/auth/token_registry.h"
#include "server/config.h"
#include "server/history/history.h"
#include "server/host/daemon_metrics.h"
#include "server/host/space_warning.h"
#include "server/rpc/rpc_server.h"
#include "server/sessions/common/decision_loop.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/storage/data_directory.h"
#include "server/storage/outbox/outbox.h"
#include "server/storage/store_thread.h"
#include "server/tls/files_watch.h"
#include "server/web/api/topic.h"
#include "server/web/http_server.h"
#include "server/web/site.h"

namespace spdlog {
class logger;
}

namespace sweepstake::server {

class Daemon {
 public:
  // Opens the store, listens, then writes the port file. Errors: INVALID_ARGUMENT (the
  // configuration), and the errors of the data directory, the database and the listener.
  static absl::StatusOr<std::unique_ptr<Daemon>> Start(const Config& config,
                                                       sessions::LoopClock& clock);
  ~Daemon();

  int port() const { return rpc_->port(); }
  int http_port() const { return web_->port(); }  // REQUIRES: Config::http is not empty
  const rpc::Counters& counters() const { return rpc_->counters(); }

  // Applies the live settings (ChangedKeys) of a configuration that was read again. Logs which
  // settings have changed and which of them need a restart, or why the configuration is invalid.
  // Called by the thread that calls Drain.
  void Reload(const absl::StatusOr<Config>& config);

  // Returns whether the daemon's own listener answers on a new connection within `patience`, and
  // the decision loop runs. Also returns true if the store cannot write or no file descriptors are
  // free, since a restart would not help.
  bool Alive(std::chrono::milliseconds patience) const;

  // Returns a flag that is true while a database whose file was removed is being copied.
  // Acknowledged evidence is lost if the process exits during that time. The flag outlives the
  // daemon.
  std::shared_ptr<const std::atomic<bool>> saving() const { return saving_; }
  const std::shared_ptr<spdlog::logger>& log() const { return log_; }

  // Sets health to NOT_SERVING, asks clients to reconnect later, and waits for pending writes.
  // Takes at most `patience` plus the time of one commit. If the database's file was removed, it
  // also takes the time of copying the database. Idempotent.
  void Drain(std::chrono::milliseconds patience = std::chrono::seconds(5));

 private:
  Daemon(const Config& config, storage::DataDirectory directory);
  absl::Status Open(sessions::LoopClock& clock);
  std::string StoreName() const;
  void StartBackups(const Config& config);
  void LimitStore(const Config& config);
  // The next three functions run on the store's thread. SaveStore copies, once, a store whose file
  // was removed. After a failure it tries again after kSavePatience, or at once if `last` is set.
  void LookAtSpace(priors::PriorStore& store);
  void ReportStore(const absl::Status& status);
  void SaveStore(priors::PriorStore& store, bool last);
  // Commits the updates that an earlier run could not commit.
  absl::Status OpenOutbox(priors::PriorStore& store);
  // Writes updates to the outbox that the store cannot commit now.
  void KeepWaiting(std::vector<priors::SourceUpdate> updates);
  // Connects the alerts to the checks, the webhook and the file of silences.
  alerts::AlertOptions AlertOptionsOf();
  std::vector<alerts::CheckResult> Checks() const;
  void Announce(const alerts::AlertChanges& changes);
  void SaveSilences(std::string text);
  absl::Status OpenTokens();
  // Runs on the token registry's thread.
  void ReportToken(const std::string& change);
  absl::Status OpenHttp();
  // Called on the HTTP thread. `next` is the earliest time of the next line in the log.
  void ReportHttpDropped(const std::string& peer, std::chrono::steady_clock::time_point& next);
  web::PageTable HttpPages();
  void FollowTls();
  // Each returns the message of a check of /livez or /readyz, or nothing if the check passes.
  std::optional<std::string> LoopProblem() const;
  std::optional<std::string> ListenerProblem(std::chrono::milliseconds patience) const;
  std::optional<std::string> StoreProblem() const;
  std::optional<std::string> TlsProblem() const;
  std::optional<std::string> ShutdownProblem() const;
  // Logs whether all evidence is on disk. REQUIRES: the store is closed.
  void ReportDrained();

  const Config config_;
  Config in_force_;    // the configuration read last; only its live settings are applied
  const bool shared_;  // whether several daemons share the store; then this one does not back it up
  const std::shared_ptr<spdlog::logger> log_;
  storage::DataDirectory directory_;  // locked until the store is closed
  DaemonMetrics metrics_;
  std::string damage_;  // evidence that was lost or damaged at the start; empty if none
  mutable std::mutex mutex_;
  std::string store_problem_;  // guarded by mutex_; why the store cannot write
  std::string tls_problem_;    // guarded by mutex_; why the TLS files cannot be used
  std::optional<std::string> unsaved_silences_;  // guarded by mutex_; waits for the store's thread
  const std::shared_ptr<std::atomic<bool>> saving_ = std::make_shared<std::atomic<bool>>(false);
  struct {
    bool done = false;
    std::chrono::steady_clock::time_point next;  // earliest time of the next attempt
  } save_;                                       // used on the store's thread
  SpaceWarning space_warning_;                   // used on the store's thread
  storage::FileId store_file_;
  std::atomic<uint64_t> database_bytes_;  // the limit in effect
  priors::AuditLimits audit_limits_;      // the limits in effect
  std::unique_ptr<auth::TokenRegistry> tokens_;
  std::unique_ptr<storage::Outbox> outbox_;  // null unless shared_; used on the store's thread
  std::unique_ptr<storage::StoreThread> store_;
  std::unique_ptr<storage::AutomaticBackups> backups_;
  std::unique_ptr<history::History> history_;
  std::unique_ptr<tls::FilesWatch> tls_watch_;  // null without TLS
  sessions::SteadyLoopClock webhook_clock_;
  alerts::Webhook webhook_;
  std::string page_url_;  // URL of the dashboard in messages of the webhook; empty: not known
  std::unique_ptr<rpc::RpcServer> rpc_;
  rpc::RpcServer* serving_ = nullptr;  // guarded by mutex_; rpc_ while it runs, else null
  std::atomic<bool> draining_ = false;
  const std::shared_ptr<web::EventCounters> events_ = std::make_shared<web::EventCounters>();
  std::unique_ptr<web::HttpServer> web_;  // its pages use the members above; null without --http
};

}  // namespace sweepstake::server
