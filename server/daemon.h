// The daemon: the prior store, the gRPC side, the HTTP side and the log wired together. The program
// runs one; tests start as many as they like in their own process.
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
#include "server/auth/token_registry.h"
#include "server/config.h"
#include "server/host/daemon_metrics.h"
#include "server/host/space_warning.h"
#include "server/rpc/rpc_server.h"
#include "server/sessions/decision_loop.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/storage/data_directory.h"
#include "server/storage/folding/evidence_folding.h"
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
  // configuration), else those of the data directory, the database and the listener.
  static absl::StatusOr<std::unique_ptr<Daemon>> Start(const Config& config, rpc::Clock& clock);
  ~Daemon();

  int port() const { return rpc_->port(); }
  int http_port() const { return web_->port(); }  // REQUIRES: Config::http is not empty
  const rpc::Counters& counters() const { return rpc_->counters(); }

  // Takes over what is live (config_settings.h) of a configuration that was read again. The log
  // names it, and what else has changed, which only a restart takes over, or says what is wrong
  // with the configuration. Called by the thread that calls Drain.
  void Reload(const absl::StatusOr<Config>& config);

  // Returns whether the daemon's own listener answers over a new connection within `patience`, and
  // decisions are made. A store that cannot write is no reason to be restarted, nor are descriptors
  // that have run out, without which nobody gets an answer over a new connection.
  bool Alive(std::chrono::milliseconds patience) const;

  // Whether what was acknowledged is being copied from a database that is gone, and would be lost
  // if the process ended now. It lives on when the daemon ends.
  std::shared_ptr<const std::atomic<bool>> saving() const { return saving_; }

  // Sets health to NOT_SERVING, tells clients to reconnect later, and waits for pending writes, all
  // within `patience` plus the time of one commit, or of saving() where that must be. Idempotent.
  void Drain(std::chrono::milliseconds patience = std::chrono::seconds(5));

 private:
  Daemon(const Config& config, storage::DataDirectory directory);
  absl::Status Open(rpc::Clock& clock);
  std::string StoreName() const;
  void StartBackups(const Config& config);
  void StartFolding(const Config& config);
  void LimitStore(const Config& config);
  // These run on the store's thread. The last one copies a store that has lost its file, once;
  // where that fails it is tried again after a while, and without waiting at the last chance.
  void LookAtSpace(priors::PriorStore& store);
  void ReportStore(const absl::Status& status);
  void SaveStore(priors::PriorStore& store, bool last);
  // Commits what an earlier run could not.
  absl::Status OpenOutbox(priors::PriorStore& store);
  // Keeps in the outbox what the store cannot take now.
  void KeepWaiting(std::vector<priors::SourceUpdate> updates);
  absl::Status OpenTokens();
  // Runs on the thread of the tokens.
  void ReportToken(const std::string& change);
  absl::Status OpenHttp();
  web::PageTable HttpPages();
  void FollowTls();
  // What the checks of /livez and /readyz say; nothing if all is well.
  std::optional<std::string> LoopProblem() const;
  std::optional<std::string> ListenerProblem(std::chrono::milliseconds patience) const;
  std::optional<std::string> StoreProblem() const;
  std::optional<std::string> TlsProblem() const;
  std::optional<std::string> ShutdownProblem() const;
  // Says what is on disk at the end, and what is not. REQUIRES: the store is closed.
  void ReportDrained();

  const Config config_;
  Config in_force_;    // as it was read last; of it, what is live
  const bool shared_;  // the store is that of several daemons, who fold and back up elsewhere
  const std::shared_ptr<spdlog::logger> log_;
  storage::DataDirectory directory_;  // locked until the store is closed
  DaemonMetrics metrics_;
  std::string damage_;  // what of the store was lost at the start
  mutable std::mutex mutex_;
  std::string store_problem_;  // guarded by mutex_; why the store cannot write
  std::string tls_problem_;    // guarded by mutex_; why the files of TLS cannot be used
  const std::shared_ptr<std::atomic<bool>> saving_ = std::make_shared<std::atomic<bool>>(false);
  struct {
    bool done = false;
    std::chrono::steady_clock::time_point next;  // not before
  } save_;                                       // used on the store's thread
  SpaceWarning space_warning_;                   // used on the store's thread
  storage::FileId store_file_;
  std::atomic<uint64_t> database_bytes_;  // in force
  priors::AuditLimits audit_limits_;      // in force
  std::unique_ptr<auth::TokenRegistry> tokens_;
  std::unique_ptr<storage::Outbox> outbox_;  // null unless shared_; used on the store's thread
  std::unique_ptr<storage::StoreThread> store_;
  std::unique_ptr<storage::AutomaticBackups> backups_;
  std::unique_ptr<tls::FilesWatch> tls_watch_;         // null without TLS
  std::unique_ptr<storage::EvidenceFolding> folding_;  // after the store, which it uses
  std::unique_ptr<rpc::RpcServer> rpc_;
  rpc::RpcServer* serving_ = nullptr;  // guarded by mutex_; rpc_ while it takes actions
  std::atomic<bool> draining_ = false;
  const std::shared_ptr<web::EventCounters> events_ = std::make_shared<web::EventCounters>();
  std::unique_ptr<web::HttpServer> web_;  // its pages use the members above; null without --http
};

}  // namespace sweepstake::server
