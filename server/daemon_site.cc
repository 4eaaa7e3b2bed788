#include "server/daemon_site.h"

#include <spdlog/logger.h>

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "engine_client/decider/policy/diagnosis.h"
#include "server/daemon.h"
#include "server/dashboard/dashboard_assets.h"
#include "server/host/descriptor_limit.h"
#include "server/rpc/common/role_table.h"
#include "server/rpc/health_probe.h"
#include "server/sessions/common/unix_time.h"
#include "server/web/health_page.h"
#include "server/web/metrics_page.h"

namespace sweepstake::server {
namespace {

// Returns whether invalid or expired TLS files may be the reason that the daemon's own listener
// does not answer. A restart would not repair them: the open streams would end and the daemon would
// not start.
bool TlsKeepsOut(const tls::Files& files) {
  if (files.cert.empty()) return false;
  const auto texts = tls::Read(files);
  return !texts.ok() || tls::EarliestExpiryUnixS(texts->cert) <= priors::UnixNowS();
}

}  // namespace

std::string PageUrl(const Config& config) {
  if (config.http.empty()) return {};
  const bool is_open = !tls::IsLoopback(config.http);
  const bool is_own_tls = is_open && !HttpTls(config).cert.empty();
  const std::string port = config.http.substr(config.http.rfind(':'));
  const std::string first_host = config.http_hosts.substr(0, config.http_hosts.find(','));
  const absl::string_view named = absl::StripAsciiWhitespace(first_host);
  if (!named.empty())
    return absl::StrCat("https://", named, is_own_tls ? port : "", config.http_base);
  const std::string host = config.http.substr(0, config.http.rfind(':'));
  const bool is_any = host.empty() || host == "0.0.0.0" || host == "[::]";
  if (is_any || port == ":0") return {};
  return absl::StrCat(is_own_tls ? "https://" : "http://", config.http, config.http_base);
}

web::ApiOptions ApiOf(rpc::RpcServer& rpc) {
  web::ApiOptions options;
  for (const rpc::Rpc& method : rpc::kRoleTable) options.methods.emplace_back(method.name);
  options.begin_call = [&rpc](auto request, const std::string& peer, const auto& token,
                              auto on_response, auto on_end) {
    return rpc.CallOverHttp({.request = std::move(request),
                             .peer = peer,
                             .on_response = std::move(on_response),
                             .on_end = std::move(on_end)},
                            token);
  };
  options.identify = [&rpc](const std::string& peer, std::optional<std::string_view> token) {
    return rpc.IdentifyOverHttp(peer, token);
  };
  options.begin_watch = [&rpc](const auto& request, const std::string& peer, const auto& token,
                               auto sink) {
    return rpc.WatchOverHttp(request, peer, token, std::move(sink));
  };
  options.post_to_loop = [&rpc](auto task) { rpc.loop().Post(std::move(task)); };
  options.asks_for_tokens = [&rpc] { return rpc.asks_over_http(); };
  options.version = SWEEPSTAKE_VERSION;
  options.stable_probability = decision::kStableProbability;
  options.tie_loss_ratio = decision::kTieLossRatio;
  return options;
}

web::MakeHandler MakeSite(web::ApiOptions api, std::set<std::string, std::less<>> hosts,
                          web::PageTable pages) {
  return [options = std::move(api), hosts = std::move(hosts),
          pages = std::move(pages)](boost::asio::io_context& io) -> web::Handler {
    const auto served = std::make_shared<web::Api>(options, io);
    const auto site = std::make_shared<web::Site>(
        web::Site::Options{.pages = pages,
                           .hosts = hosts,
                           .files = web::DashboardFiles(DashboardAssets(), DashboardProblem()),
                           .api = [served](const auto& exchange) { served->Handle(exchange); }});
    return [site](const auto& exchange) { site->Handle(exchange); };
  };
}

web::PageTable Daemon::HttpPages() {
  const std::vector<web::HealthCheck> live = {{"decision-loop", [this] { return LoopProblem(); }}};
  const std::vector<web::HealthCheck> ready = {
      live.front(),
      {"store", [this] { return StoreProblem(); }, damage_},
      {"tls", [this] { return TlsProblem(); }},
      {"shutdown", [this] { return ShutdownProblem(); }}};
  web::PageTable pages;
  pages["/livez"] = [live](std::string_view query) { return HealthPage("livez", live, query); };
  pages["/readyz"] = [ready](std::string_view query) { return HealthPage("readyz", ready, query); };
  pages["/metrics"] = [this](std::string_view /*query*/) {
    return web::MetricsPage(metrics_.Collect(rpc_->counters(), *events_,
                                             {.healthy = store_->healthy(),
                                              .queued_commit_count = store_->queued_count(),
                                              .queued_read_count = store_->queued_read_count(),
                                              .database = directory_.database()},
                                             *rpc_->alert_figures(), webhook_.counters()));
  };
  return pages;
}

std::optional<std::string> Daemon::LoopProblem() const {
  if (rpc_->responsive()) return std::nullopt;
  return "the decision loop does not answer";
}

std::optional<std::string> Daemon::StoreProblem() const {
  if (store_->can_write()) {
    if (store_->can_read()) return std::nullopt;
    return "a read of the prior store has not finished; new sessions start without its evidence";
  }
  const std::lock_guard lock(mutex_);
  return "the prior store cannot write; decisions continue in memory: " + store_problem_;
}

std::optional<std::string> Daemon::TlsProblem() const {
  const std::lock_guard lock(mutex_);
  if (tls_problem_.empty()) return std::nullopt;
  return "the TLS files are invalid: " + tls_problem_;
}

std::optional<std::string> Daemon::ShutdownProblem() const {
  if (!draining_) return std::nullopt;
  return "the daemon is draining";
}

bool Daemon::Alive(std::chrono::milliseconds patience) const {
  std::optional<std::string> problem = LoopProblem();
  if (!problem) problem = ListenerProblem(patience);
  if (problem && !draining_) log_->error("not alive: {}", *problem);
  return !problem;
}

std::optional<std::string> Daemon::ListenerProblem(std::chrono::milliseconds patience) const {
  const std::string host = config_.listen.substr(0, config_.listen.rfind(':'));
  const std::string address = absl::StrCat(host, ":", rpc_->port());
  const auto health = rpc::ProbeHealth(address, config_.rpc.tls, patience);
  if (health.ok()) return std::nullopt;
  if (DescriptorsRanOut()) {
    // Connected games are still served, and a restart would end their streams.
    log_->warn(
        "no file descriptors are free, so new connections wait: raise the limit of open files "
        "(LimitNOFILE of systemd, ulimit -n), or lower --max-sessions");
    return std::nullopt;
  }
  if (TlsKeepsOut(config_.rpc.tls)) return std::nullopt;
  return absl::StrCat("the daemon's own listener does not answer: ", health.status().message());
}

}  // namespace sweepstake::server
