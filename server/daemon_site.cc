#include "server/daemon_site.h"

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "server/daemon_files.h"
#include "server/dashboard/dashboard_assets.h"
#include "server/rpc/common/role_table.h"

namespace sweepstake::server {

web::ApiOptions ApiOf(const Config& config, rpc::RpcServer& rpc) {
  web::ApiOptions options;
  options.channel = rpc.own_channel();
  options.caller_key = rpc::kCallerKey;
  for (const rpc::Rpc& method : rpc::kRoleTable) options.methods.emplace_back(method.name);
  options.identify = [&rpc](const std::string& caller, std::optional<std::string_view> token) {
    return rpc.IdentifyOverHttp(caller, token);
  };
  options.asks_for_tokens = [&rpc] { return rpc.asks_over_http(); };
  options.version = SWEEPSTAKE_VERSION;
  // As gRPC does: where it has TLS, plain text over a network is for /metrics and the like alone.
  options.takes_tokens_from_afar = config.rpc.tls.cert.empty();
  return options;
}

void KeepLogins(const std::filesystem::path& path, const std::shared_ptr<spdlog::logger>& log,
                web::ApiOptions& api) {
  auto logins = ReadLogins(path);
  if (logins.ok()) {
    api.logins = *std::move(logins);
  } else {
    log->warn("{}", std::string(logins.status().message()));
  }
  api.keep_logins = [path, log](const std::vector<web::Login>& all) {
    if (const absl::Status kept = WriteLogins(path, all); !kept.ok())
      log->warn("logins to the page end with this daemon: {}", std::string(kept.message()));
  };
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

}  // namespace sweepstake::server
