// The daemon's HTTP site, connected to its services. daemon_site.cc also defines the health checks
// of daemon.h.
#pragma once

#include <set>
#include <string>

#include "server/config.h"
#include "server/rpc/rpc_server.h"
#include "server/web/api/api.h"
#include "server/web/http_server.h"
#include "server/web/site.h"

namespace sweepstake::server {

// Returns options for an API that calls the services of `rpc`, which must outlive the API.
// REQUIRES: the configuration is valid.
web::ApiOptions ApiOf(rpc::RpcServer& rpc);

// Returns the URL under which people reach the dashboard, without a trailing slash; empty if the
// configuration does not contain it. The first name of http_hosts is that of a proxy with HTTPS
// unless the daemon's own listener is open to other machines.
std::string PageUrl(const Config& config);

// Returns a handler for the dashboard, the API and the pages. `hosts` are the accepted host names,
// as in Site::Options.
web::MakeHandler MakeSite(web::ApiOptions api, std::set<std::string, std::less<>> hosts,
                          web::PageTable pages);

}  // namespace sweepstake::server
