#include "server/web/site.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

namespace http = boost::beast::http;

// A page of the dashboard. A POST to its path is of the API.
constexpr std::string_view kLogin = "/login";

Page MethodPage(const std::string& methods) {
  return {.status = 405,
          .body = absl::StrCat("Only ", methods, " are valid here.\n"),
          .headers = {{"Allow", methods}}};
}

bool IsOfApi(const Request& request) {
  const std::string_view path = request.path();
  return path.starts_with("/api/") || path.starts_with("/events/") || path.starts_with("/csv/") ||
         path == "/logout" || (request.is_post() && path == kLogin);
}

// Returns the host of HOST or HOST:PORT in lower case. Returns nothing if the port is not a number,
// as in "localhost:80.evil.example".
std::optional<std::string> HostOf(std::string_view value) {
  const size_t found = value.starts_with('[') ? value.find(']') + 1 : value.find(':');
  const size_t end = std::min(found, value.size());
  const std::string_view port = value.substr(std::min(end + 1, value.size()));
  const bool has_port = end < value.size();
  if (has_port &&
      (value[end] != ':' || !std::all_of(port.begin(), port.end(), absl::ascii_isdigit)))
    return std::nullopt;
  return absl::AsciiStrToLower({value.data(), end});
}

// Returns whether the request comes from the page of another site, according to the browser.
bool IsCrossSite(const Request& request) {
  const std::string_view site = request.Header("Sec-Fetch-Site");
  if (!site.empty() && site != "same-origin" && site != "none") return true;
  const std::string_view origin = request.Header("Origin");
  if (origin.empty()) return false;
  const size_t scheme_end = origin.find("://");
  const std::string_view host = request.Header("Host");
  return scheme_end == std::string_view::npos ||
         !absl::EqualsIgnoreCase({origin.data() + scheme_end + 3, origin.size() - scheme_end - 3},
                                 {host.data(), host.size()});
}

}  // namespace

void Site::Handle(const std::shared_ptr<Exchange>& exchange) const {
  if (std::optional<Page> page = PageFor(exchange->request()))
    return exchange->Answer(*std::move(page));
  options_.api(exchange);
}

std::optional<Page> Site::PageFor(const Request& request) const {
  const http::verb method = request.message.method();
  const bool reads = method == http::verb::get || method == http::verb::head;
  if (!request.target().starts_with('/'))
    return Page{400, "The target of a request must begin with a slash.\n"};
  if (const auto page = options_.pages.find(request.path()); page != options_.pages.end())
    return reads ? page->second(request.query()) : MethodPage("GET, HEAD");
  if (!IsKnownHost(request)) {
    return Page{403,
                "This daemon does not serve the host name in the Host header: use its address, or "
                "add the name to http_hosts.\n"};
  }
  if (!IsOfApi(request)) {
    if (reads) return options_.files.PageFor(request);
    return MethodPage(request.path() == kLogin ? "GET, HEAD, POST" : "GET, HEAD");
  }
  if (IsCrossSite(request))
    return ErrorPage(absl::PermissionDeniedError(
        "a page of another site sent this request, which is not allowed"));
  if (request.is_post() && request.Header("X-Sweepstake") != "1") {
    return ErrorPage(absl::PermissionDeniedError(
        "a POST needs the header `X-Sweepstake: 1`, which other sites' pages cannot set"));
  }
  return std::nullopt;
}

bool Site::IsKnownHost(const Request& request) const {
  if (request.message.count(http::field::host) != 1) return false;
  const std::optional<std::string> host = HostOf(request.Header("Host"));
  return host && (tls::IsLoopback(*host + ":") || *host == request.own_host ||
                  options_.hosts.contains(*host));
}

}  // namespace sweepstake::web
