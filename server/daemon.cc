#include "server/daemon.h"

#include <spdlog/logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <filesystem>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/daemon_files.h"
#include "server/daemon_site.h"
#include "server/host/descriptor_limit.h"
#include "server/sessions/common/unix_time.h"
#include "server/storage/commit_mark.h"
#include "server/storage/postgres/shared_store.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::server {
namespace fs = std::filesystem;
namespace {

// Between two attempts to copy a store whose file was removed.
constexpr std::chrono::minutes kSavePatience{1};
// Between two log lines about closed HTTP connections.
constexpr std::chrono::minutes kHttpNoteInterval{1};
constexpr int64_t kDayS = 86'400;

// Formats %J as the message in a JSON string.
class JsonMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    out.push_back('"');
    for (const char c : message.payload) Append(c, out);
    out.push_back('"');
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JsonMessage>();
  }

 private:
  static void Append(char c, spdlog::memory_buf_t& out) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out.push_back('\\');
      out.push_back(c);
    } else if (byte < 0x20) {
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", byte);
    } else {
      out.push_back(c);
    }
  }
};

spdlog::level::level_enum LevelOf(const std::string& level) {
  return level == "warn" ? spdlog::level::warn : spdlog::level::from_str(level);
}

// Returns a thread-safe log that writes JSON lines to stderr, with time (UTC), level and message.
// `level` as in Config::log_level.
std::shared_ptr<spdlog::logger> MakeLog(const std::string& level) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  formatter->add_flag<JsonMessage>('J');
  formatter->set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","message":%J})");
  auto log = std::make_shared<spdlog::logger>("sweepstaked",
                                              std::make_shared<spdlog::sinks::stderr_sink_mt>());
  log->set_formatter(std::move(formatter));
  log->set_level(LevelOf(level));
  log->flush_on(spdlog::level::trace);
  return log;
}

rpc::RpcOptions RpcOptionsOf(const Config& config) {
  rpc::RpcOptions options = config.rpc;
  options.keeps_audit = config.audit.bytes > 0;
  return options;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Daemon>> Daemon::Start(const Config& config,
                                                      sessions::LoopClock& clock) {
  if (absl::Status status = Validate(config); !status.ok()) return status;
  auto directory = storage::DataDirectory::Open(config.data);
  if (!directory.ok()) return directory.status();
  std::unique_ptr<Daemon> daemon(new Daemon(config, *std::move(directory)));
  if (absl::Status status = daemon->Open(clock); !status.ok()) return status;
  return daemon;
}

Daemon::Daemon(const Config& config, storage::DataDirectory directory)
    : config_(config),
      in_force_(config),
      shared_(!config.store.empty()),
      log_(MakeLog(config.log_level)),
      directory_(std::move(directory)),
      metrics_(SWEEPSTAKE_VERSION),
      database_bytes_(config.database_bytes),
      audit_limits_(config.audit),
      webhook_({.user_agent = "sweepstaked/" SWEEPSTAKE_VERSION,
                .on_problem =
                    [this](const std::string& problem) {
                      log_->error(
                          "an alert could not be sent to the webhook: {}; the daemon tries again "
                          "(at most one line per minute)",
                          problem);
                    }},
               webhook_clock_),
      page_url_(PageUrl(config)) {
  webhook_.SetUrl(config.webhook);
}

absl::Status Daemon::Open(sessions::LoopClock& clock) {
  if (directory_.open_to_others()) {
    log_->warn(
        "other users can read the data directory {}, which contains the key of its sessions; chmod "
        "it to 0700",
        config_.data.string());
  }
  if (const auto shortage = DescriptorShortage(RaiseDescriptorLimit(), config_.rpc))
    log_->warn("{}", *shortage);
  auto opened = shared_ ? storage::OpenSharedStore(config_.store, config_.audit)
                        : storage::OpenStoreOrBackup(
                              directory_.database(), config_.audit, config_.database_bytes,
                              [this](auto duration) { metrics_.OnSync(duration); });
  if (!opened.ok()) return opened.status();
  auto key = ReadResumeKey(directory_.resume_key());
  if (key.ok() && shared_) key = storage::SharedResumeKey(*opened->store, *key);
  if (!key.ok()) return key.status();
  if (shared_) {
    if (absl::Status status = OpenOutbox(*opened->store); !status.ok()) return status;
  } else if (absl::Status status = storage::CheckDelivered(directory_.outbox()); !status.ok()) {
    log_->warn("{}", std::string(status.message()));
  }
  damage_ = std::move(opened->damage);
  if (!damage_.empty()) log_->error("{}", damage_);
  metrics_.SetDamaged(!damage_.empty());
  metrics_.SetMaxStoreBytes(config_.database_bytes);
  storage::StoreThreadOptions store_options;
  if (shared_) store_options.group_rows = storage::kSharedGroupRows;
  if (!shared_) {
    store_options.on_check = [this, mark = storage::CommitMark(directory_.database())](
                                 priors::PriorStore& store) mutable {
      LookAtSpace(store);
      if (const auto count = storage::CountCommits(store); count.ok()) mark.Write(*count);
    };
  }
  store_options.on_health = [this](const absl::Status& status) { ReportStore(status); };
  store_options.on_misplaced = [this](auto& store, bool last) { SaveStore(store, last); };
  store_file_ = opened->file;
  store_options.on_refusal = [this](const priors::SourceUpdate& update, const absl::Status& why) {
    log_->log(absl::IsFailedPrecondition(why) ? spdlog::level::info : spdlog::level::err,
              "the store refused {} increments of session {}: {}", update.increments.size(),
              update.progress.source_id, std::string(why.message()));
  };
  store_options.on_commit = [this](auto duration) { metrics_.OnCommit(duration); };
  store_options.on_read = [this](auto duration) { metrics_.OnRead(duration); };
  store_ = std::make_unique<storage::StoreThread>(
      std::move(opened->store), std::move(store_options), std::move(opened->reads));
  const PortFile port_file(config_.port_file);
  if (absl::Status status = port_file.Remove(); !status.ok()) return status;
  if (absl::Status status = OpenTokens(); !status.ok()) return status;
  auto history = history::History::Open(directory_.history(), config_.history,
                                        [this](const auto& problem) { log_->warn("{}", problem); });
  if (history.ok()) {
    history_ = *std::move(history);
  } else {
    log_->error("there is no history: {}", std::string(history.status().message()));
  }
  rpc::RpcOptions options = RpcOptionsOf(config_);
  options.tokens = tokens_.get();
  options.history = history_.get();
  options.resume_secret = *std::move(key);
  options.daemon_version = SWEEPSTAKE_VERSION;
  options.shares_store = shared_;
  if (shared_) options.keep_waiting = [this](auto updates) { KeepWaiting(std::move(updates)); };
  options.alerts = AlertOptionsOf();
  options.on_timer = [this](auto lateness) { metrics_.OnTimer(lateness); };
  auto server = rpc::RpcServer::Start(config_.listen, std::move(options), clock, *store_, *log_);
  if (!server.ok()) return server.status();
  rpc_ = *std::move(server);
  {
    const std::lock_guard lock(mutex_);
    serving_ = rpc_.get();
  }
  if (absl::Status status = OpenHttp(); !status.ok()) return status;
  StartBackups(config_);
  FollowTls();
  const std::optional<int> http_port = web_ ? std::optional(web_->port()) : std::nullopt;
  if (absl::Status status = port_file.Write(rpc_->port(), http_port); !status.ok()) return status;
  const auto& tls = config_.rpc.tls;
  log_->info("serving on port {} ({}, {}), priors in {}", rpc_->port(),
             tls.cert.empty() ? "plain text"
             : tls.ca.empty() ? "TLS"
                              : "TLS with client certificates",
             tokens_->empty() ? "without tokens" : "with tokens", StoreName());
  return absl::OkStatus();
}

absl::Status Daemon::OpenOutbox(priors::PriorStore& store) {
  auto outbox = storage::Outbox::Open(directory_.outbox());
  if (!outbox.ok()) return outbox.status();
  outbox_ = std::make_unique<storage::Outbox>(*std::move(outbox));
  const auto delivery = outbox_->DeliverTo(store);
  if (!delivery.ok()) return delivery.status();
  if (delivery->committed_count + delivery->refused_count > 0) {
    log_->info("{} updates that an earlier run kept in {} are now stored in {}; {} were refused",
               delivery->committed_count, directory_.outbox().string(), StoreName(),
               delivery->refused_count);
  }
  return absl::OkStatus();
}

void Daemon::KeepWaiting(std::vector<priors::SourceUpdate> updates) {
  const auto report = [this](absl::string_view why) {
    log_->error("{} could not be written, so new evidence is in memory only: {}",
                directory_.outbox().string(), std::string(why));
  };
  const bool submitted =
      store_->Submit([this, report, updates = std::move(updates)](priors::PriorStore& /*store*/) {
        if (const absl::Status kept = outbox_->Replace(updates); !kept.ok()) report(kept.message());
      });
  if (!submitted) report("the queue of the store is full");
}

std::string Daemon::StoreName() const {
  return shared_ ? config_.store : directory_.database().string();
}

void Daemon::StartBackups(const Config& config) {
  if (shared_) return;
  storage::BackupPlan plan;
  plan.interval = std::chrono::hours(config.backup_hours);
  plan.count = config.backup_count;
  plan.file = store_file_;
  backups_ = std::make_unique<storage::AutomaticBackups>(
      directory_.database(), plan, [this](const absl::StatusOr<storage::MadeBackup>& made) {
        if (!made.ok())
          return log_->error("could not make a backup: {}", std::string(made.status().message()));
        log_->info("backed up to {}", made->file.string());
        if (made->damaged_row_count > 0)
          log_->error(
              "{} damaged rows of {} are not in the backup; check the disk, and `sweepstaked "
              "restore` an earlier backup to get the priors of their scenes back",
              made->damaged_row_count, directory_.database().string());
      });
}

void Daemon::FollowTls() {
  const tls::Files& files = config_.rpc.tls;
  if (files.cert.empty()) return;
  const auto expiry = [path = files.cert.string()](int64_t expires_unix_s) {
    const int64_t days = (expires_unix_s - priors::UnixNowS()) / kDayS;
    return expires_unix_s > priors::UnixNowS()
               ? absl::StrCat("the certificate ", path, " expires in ", days, " days")
               : absl::StrCat("the certificate ", path, " expired ", -days, " days ago");
  };
  tls::FilesWatchOptions options;
  options.unix_now_s = priors::UnixNowS;
  options.on_change = [this, expiry](const absl::Status& status, int64_t expires_unix_s) {
    {
      const std::lock_guard lock(mutex_);
      tls_problem_ = std::string(status.message());
    }
    metrics_.SetTls(status.ok(), expires_unix_s);  // set after tls_problem_, so that /readyz agrees
    if (status.ok()) {
      log_->info("read the TLS files; {}", expiry(expires_unix_s));
    } else {
      log_->error("the TLS files are invalid, and the previous certificate stays in use: {}",
                  std::string(status.message()));
    }
  };
  options.on_expiry = [this, expiry](int64_t expires_unix_s) {
    log_->warn(
        "{}; clients refuse an expired certificate: replace it and its key; this needs no "
        "restart",
        expiry(expires_unix_s));
  };
  tls_watch_ = std::make_unique<tls::FilesWatch>(files, std::move(options));
}

absl::Status Daemon::OpenTokens() {
  auth::TokenRegistryOptions options;
  options.unix_now_s = priors::UnixNowS;
  options.on_change = [this](const std::string& text) { ReportToken(text); };
  options.on_problem = [this](const absl::Status& status) {
    log_->error("the token file is invalid, so the tokens read before stay in effect: {}",
                std::string(status.message()));
  };
  auto tokens = auth::TokenRegistry::Open(directory_.tokens(), std::move(options));
  if (!tokens.ok()) return tokens.status();
  tokens_ = *std::move(tokens);
  if (!tokens_->empty() || !NeedsToken(config_)) return absl::OkStatus();
  if (config_.require_tokens || config_.rpc.trusts_proxy) {
    return absl::FailedPreconditionError(
        absl::StrCat(config_.require_tokens ? "require_tokens" : "trusted_proxy",
                     ": there is no token; create one with `sweepstaked token create`"));
  }
  const bool is_http = tls::IsLoopback(config_.listen);
  return absl::FailedPreconditionError(
      absl::StrCat(is_http ? "http" : "listen", ": other machines can reach ",
                   is_http ? config_.http : config_.listen,
                   " and there is no token; create one with `sweepstaked token create`, set "
                   "--tls-client-ca, listen on 127.0.0.1, or allow everyone with --insecure"));
}

void Daemon::ReportToken(const std::string& change) {
  log_->info("{}", change);
  const std::lock_guard lock(mutex_);
  if (serving_ != nullptr) serving_->RecordAction("", change);
}

void Daemon::LookAtSpace(priors::PriorStore& store) {
  const auto used_bytes = storage::UsedBytes(store);
  if (!used_bytes.ok()) return;  // the next commit reports the error
  metrics_.SetUsedStoreBytes(*used_bytes);
  const auto warning =
      space_warning_.Look(*used_bytes, database_bytes_, std::chrono::steady_clock::now());
  if (warning) log_->warn("{}: {}", directory_.database().string(), *warning);
}

void Daemon::ReportStore(const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    store_problem_ = std::string(status.message());
  }
  if (!absl::IsNotFound(status)) save_ = {};
  if (status.ok()) {
    log_->info("{} can be written again", StoreName());
  } else if (absl::IsNotFound(status)) {
    log_->error(
        "{}; nothing more is acknowledged. Put the file back, or wait until the log reports that "
        "its content was copied",
        std::string(status.message()));
  } else if (shared_) {
    log_->error("{} cannot be written: {}; this daemon keeps new evidence until it can write again",
                StoreName(), std::string(status.message()));
  } else {
    log_->error("{} cannot be written: {}; make room on the disk, or raise database_mb ({} now)",
                directory_.database().string(), std::string(status.message()),
                database_bytes_ >> 20);
  }
}

void Daemon::SaveStore(priors::PriorStore& store, bool last) {
  const auto now = std::chrono::steady_clock::now();
  if (save_.done || (now < save_.next && !last)) return;
  save_.next = now + kSavePatience;
  const std::string path = directory_.database().string();
  *saving_ = true;
  const auto saved = storage::SaveMisplacedStore(store, path);
  *saving_ = false;
  if (!saved.ok()) {
    log_->error(
        "the prior store cannot be copied ({}), and its content is lost when the daemon ends "
        "unless you put {} back; make room on the disk; the daemon tries again in a minute",
        std::string(saved.status().message()), path);
    return;
  }
  save_.done = true;
  const std::string what = absl::StrCat(
      "all acknowledged evidence is in ", saved->string(), ": stop the daemon, move ", path, ", ",
      path, "-wal and ", path, "-shm away if they exist, run `sweepstaked restore ",
      saved->string(), " --data ", config_.data.string(),
      "`, and start the daemon again. Later evidence is lost at the stop, unless you put the file "
      "back first, or the game still runs and sends it again");
  log_->error("{}", what);
  const std::lock_guard lock(mutex_);
  absl::StrAppend(&store_problem_, "; ", what);
}

absl::Status Daemon::OpenHttp() {
  if (config_.http.empty()) return absl::OkStatus();
  web::ApiOptions api = ApiOf(*rpc_);
  api.event_counters = events_;
  const tls::Files tls = HttpTls(config_);
  auto server = web::HttpServer::Start(
      config_.http, MakeSite(std::move(api), HttpHosts(config_), HttpPages()), tls,
      {.trusts_proxy = config_.rpc.trusts_proxy, .base_path = config_.http_base},
      [this, next = std::chrono::steady_clock::time_point()](const std::string& peer) mutable {
        ReportHttpDropped(peer, next);
      });
  if (!server.ok()) return server.status();
  web_ = *std::move(server);
  const bool is_plain = tls.cert.empty();
  log_->info("serving the dashboard, /metrics, /livez and /readyz by {} on port {}",
             is_plain ? "HTTP" : "HTTPS", web_->port());
  if (is_plain && !tls::IsLoopback(config_.http)) {
    log_->warn(
        "http: other machines can reach {}, and the network can read tokens and the dashboard in "
        "plain text",
        config_.http);
  }
  return absl::OkStatus();
}

void Daemon::ReportHttpDropped(const std::string& peer,
                               std::chrono::steady_clock::time_point& next) {
  metrics_.OnHttpDropped();
  const auto now = std::chrono::steady_clock::now();
  if (now < next) return;
  next = now + kHttpNoteInterval;
  log_->warn(
      "http: all connections are taken, and the longest idle one was closed, that of {}; "
      "sweepstake_dropped_http_connections_total counts them (at most one line per minute)",
      peer);
}

void Daemon::Reload(const absl::StatusOr<Config>& config) {
  if (!config.ok()) {
    log_->error("the configuration is invalid and was not applied: {}",
                std::string(config.status().message()));
    return;
  }
  for (const std::string& key : ChangedSettings(config_, *config).fixed)
    log_->warn("{} has changed; restart the daemon to apply it", key);
  const std::vector<std::string> changed = ChangedSettings(in_force_, *config).live;
  LimitStore(*config);
  if (history_ != nullptr) history_->Limit(config->history);
  rpc_->Adjust(RpcOptionsOf(*config));
  webhook_.SetUrl(config->webhook);
  if (config->backup_count != in_force_.backup_count ||
      config->backup_hours != in_force_.backup_hours) {
    backups_.reset();
    StartBackups(*config);
  }
  in_force_ = *config;
  log_->set_level(LevelOf(config->log_level));
  log_->info("read the configuration again; the log level is {}; applied: {}", config->log_level,
             changed.empty() ? "no changes" : absl::StrJoin(changed, ", "));
}

void Daemon::LimitStore(const Config& config) {
  if (config.database_bytes == database_bytes_ && config.audit == audit_limits_) return;
  const auto limit = [audit = config.audit, bytes = config.database_bytes](auto& store) {
    storage::LimitStore(store, audit, bytes).IgnoreError();  // commits report it
  };
  if (store_->Submit(limit)) {
    database_bytes_ = config.database_bytes;
    audit_limits_ = config.audit;
    metrics_.SetMaxStoreBytes(config.database_bytes);
  } else {
    log_->error(
        "database_mb, audit_mb and audit_days were not applied, because the queue of the store is "
        "full; send SIGHUP again");
  }
}

void Daemon::Drain(std::chrono::milliseconds patience) {
  if (draining_.exchange(true)) return;
  if (backups_ != nullptr) backups_->Stop();
  // A large import could take longer than ExitGuard waits.
  if (store_ != nullptr) store_->StopChanges();
  if (rpc_ != nullptr) {
    log_->info("draining: asking clients to reconnect later");
    rpc_->Drain(patience);
  }
  if (history_ != nullptr) history_->Close();
  if (store_ != nullptr) store_->Close();
  // Stopping a backup can take long, because the page check of a large copy cannot be interrupted.
  // Therefore the store is closed before this.
  backups_.reset();
  if (rpc_ != nullptr) ReportDrained();
}

void Daemon::ReportDrained() {
  const sessions::HeldEvidence held = rpc_->CountHeld();
  if (held.session_count == 0) return log_->info("drained: all acknowledged evidence is on disk");
  log_->warn(
      "drained: all acknowledged evidence is on disk, but later evidence of {} sessions is not; "
      "running games send it again; {} of the sessions have ended, and their evidence is {}",
      held.session_count, held.ended_session_count,
      shared_ ? "in " + directory_.outbox().string() : "lost");
}

Daemon::~Daemon() {
  Drain(std::chrono::milliseconds(0));
  web_.reset();
  {
    const std::lock_guard lock(mutex_);
    serving_ = nullptr;
  }
  // Drain has closed the store, so the store's last callbacks have run. The gRPC server must end
  // before the store that it uses.
  rpc_.reset();
}

}  // namespace sweepstake::server
