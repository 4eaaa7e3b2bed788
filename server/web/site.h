// Maps paths to answers: the pages for operators and their programs, the files of the dashboard,
// and the API that the dashboard uses. Used on the server's thread.
//
// The pages for operators need no login. Other requests are answered only if their Host is a name
// of the daemon, which prevents DNS rebinding. The API refuses requests from the pages of other
// sites.
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
// Page makers by path.
using PageTable = std::map<std::string, PageMaker, std::less<>>;

class Site {
 public:
  struct Options {
    PageTable pages;
    // Accepted host names of the daemon, in lower case and without ports. Loopback names and the
    // address that the client has connected to are always accepted.
    std::set<std::string, std::less<>> hosts = {};
    DashboardFiles files = DashboardFiles({}, "");
    // Answers /api/, /events/ and /csv/, and POST requests to /login and /logout.
    Handler api = {};
  };

  explicit Site(Options options) : options_(std::move(options)) {}

  void Handle(const std::shared_ptr<Exchange>& exchange) const;

 private:
  // Returns the answer; nothing if the API answers.
  std::optional<Page> PageFor(const Request& request) const;
  bool IsKnownHost(const Request& request) const;

  const Options options_;
};

}  // namespace sweepstake::web
