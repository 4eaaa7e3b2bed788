// What a daemon has at its HTTP address, wired to its services. What daemon.h says of its health is
// defined beside it.
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

// Returns what the API of these services is made from. They must outlive it. REQUIRES: the
// configuration is valid.
web::ApiOptions ApiOf(const Config& config, rpc::RpcServer& rpc);

// Lets logins go on from the run of the daemon before, and into the next one, by this file.
void KeepLogins(const std::filesystem::path& path, const std::shared_ptr<spdlog::logger>& log,
                web::ApiOptions& api);

// Returns the dashboard, that API and the pages. `hosts` as in Site::Options.
web::MakeHandler MakeSite(web::ApiOptions api, std::set<std::string, std::less<>> hosts,
                          web::PageTable pages);

}  // namespace sweepstake::server
