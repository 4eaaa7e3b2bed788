// What the server has at which path: the pages for operators and their programs, the dashboard's
// files, and the API that the dashboard speaks. Used on the server's thread.
//
// The pages are open to all. All else is answered only where the request's Host is a name of the
// daemon, so that no other site's name can be made to lead here. What the API does is asked for by
// the daemon's own pages or by programs: a request that another site's page makes is refused.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "server/web/dashboard_files.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

// Makes a page from the request's query.
using PageMaker = std::function<Page(std::string_view query)>;
// The makers by path.
using PageTable = std::map<std::string, PageMaker, std::less<>>;

class Site {
 public:
  struct Options {
    PageTable pages;
    // Names of the daemon in lower case, without ports, beside those of loopback and the address
    // that the client has connected to.
    std::set<std::string, std::less<>> hosts = {};
    DashboardFiles files = DashboardFiles({}, "");
    // Answers /api/ and /events/, and what is posted to /login and /logout.
    Handler api = {};
  };

  explicit Site(Options options) : options_(std::move(options)) {}

  void Handle(const std::shared_ptr<Exchange>& exchange) const;

 private:
  // Returns the answer; nothing if the API has it.
  std::optional<Page> PageFor(const Request& request) const;
  bool IsKnownHost(const Request& request) const;

  const Options options_;
};

}  // namespace sweepstake::web
