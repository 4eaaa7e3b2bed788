// Connects the pages at a daemon's HTTP address to its services. The source file also defines the
// health checks that daemon.h declares.
#pragma once

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

// Returns the dashboard, that API and the pages. `hosts` as in Site::Options.
web::MakeHandler MakeSite(web::ApiOptions api, std::set<std::string, std::less<>> hosts,
                          web::PageTable pages);

}  // namespace sweepstake::server
