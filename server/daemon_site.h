// The daemon's HTTP site, connected to its services. daemon_site.cc also defines the health checks
// of daemon.h.
#pragma once

#include <spdlog/logger.h>

#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include "server/config.h"
#include "server/rpc/rpc_server.h"
#include "server/web/api/api.h"
#include "server/web/http_server.h"
#include "server/web/site.h"

namespace sweepstake::server {

// Returns the options of the API to `rpc`, which must outlive the API. REQUIRES: the configuration
// is valid.
web::ApiOptions ApiOf(const Config& config, rpc::RpcServer& rpc);

// Keeps logins in this file, so that they survive a restart of the daemon.
void KeepLogins(const std::filesystem::path& path, const std::shared_ptr<spdlog::logger>& log,
                web::ApiOptions& api);

// Returns a handler for the dashboard, the API and the pages. `hosts` as in Site::Options.
web::MakeHandler MakeSite(web::ApiOptions api, std::set<std::string, std::less<>> hosts,
                          web::PageTable pages);

}  // namespace sweepstake::server
