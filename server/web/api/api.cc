#include "server/web/api/api.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/net/peer_address.h"
#include "server/sessions/common/unix_time.h"
#include "server/web/error_page.h"
#include "server/web/query.h"

namespace sweepstake::web {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kCalls = "/api/";
constexpr std::string_view kEvents = "/events/";
constexpr std::string_view kCsv = "/csv/";
constexpr std::string_view kWhoAmI = "/api/whoami";
constexpr absl::string_view kScheme = "Bearer ";
constexpr size_t kMaxTokenBytes = 256;
constexpr int kNoContent = 204;

Page OnlyPage(const std::string& method) {
  return {.status = 405,
          .body = absl::StrCat("Only ", method, " is valid here.\n"),
          .headers = {{"Allow", method}}};
}

// Returns whether the text can be a token in a header.
bool LooksLikeToken(std::string_view text) {
  return !text.empty() && text.size() <= kMaxTokenBytes &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
}

// Returns the name of the daemon's cookie, with its equals sign. It contains the port, because
// browsers send cookies to all ports of a host, where other daemons may listen. The port is taken
// from the browser's request, and may be the port of a tunnel or a proxy.
std::string CookieName(const Request& request) {
  const std::string_view host = request.Header("Host");
  const std::string_view port = host.substr(host.find_last_not_of("0123456789") + 1);
  const bool has_port = port.size() < host.size() && host[host.size() - port.size() - 1] == ':';
  return absl::StrCat("sweepstake", has_port ? absl::StrCat("-", std::string(port)) : "", "=");
}

// Returns the value of the daemon's cookie; empty if it is absent.
std::string CookieOf(const Request& request) {
  const std::string name = CookieName(request);
  const std::string_view cookies = request.Header("Cookie");
  for (absl::string_view cookie :
       absl::StrSplit(absl::string_view(cookies.data(), cookies.size()), ';')) {
    cookie = absl::StripAsciiWhitespace(cookie);
    if (absl::StartsWith(cookie, name)) return std::string(cookie.substr(name.size()));
  }
  return {};
}

// Returns the header that sets the cookie. After a login over TLS, browsers send the cookie over
// TLS only.
std::pair<std::string, std::string> SetCookie(const Request& request, const std::string& value) {
  const bool is_safe = request.is_tls || request.Header("X-Forwarded-Proto") == "https";
  return {"Set-Cookie",
          absl::StrCat(CookieName(request), value,
                       "; HttpOnly; SameSite=Strict; Path=", request.base_path, "/",
                       is_safe ? "; Secure" : "", value.empty() ? "; Max-Age=0" : "")};
}

// Returns the token of {"token":"…"}; empty if the text has another form.
std::string TokenIn(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto token = json.is_object() ? json.find("token") : json.end();
  return token != json.end() && token->is_string() ? token->get<std::string>() : "";
}

absl::Status UnknownMethod() {
  return absl::NotFoundError("the daemon has no method of this name that can be called over HTTP");
}

}  // namespace

Api::Api(ApiOptions options, boost::asio::io_context& io)
    : options_(std::move(options)),
      methods_(options_.methods),
      calls_(options_.begin_call, io),
      topics_(io, options_.begin_watch, options_.post_to_loop, options_.events,
              *options_.event_counters) {}

void Api::Handle(const std::shared_ptr<Exchange>& exchange) {
  const Request& request = exchange->request();
  const std::string_view path = request.path();
  const bool is_get = request.message.method() == boost::beast::http::verb::get;
  if (path == "/login") return exchange->Answer(LogIn(request));
  if (path == "/logout")
    return exchange->Answer(request.is_post() ? LogOut(request) : OnlyPage("POST"));
  if (path == kWhoAmI) return exchange->Answer(is_get ? WhoAmI(request) : OnlyPage("GET"));
  if (path.starts_with(kEvents) || path.starts_with(kCsv)) {
    if (!is_get) return exchange->Answer(OnlyPage("GET"));
    return path.starts_with(kCsv) ? WriteCsv(exchange, path.substr(kCsv.size()))
                                  : Watch(exchange, path.substr(kEvents.size()));
  }
  if (!request.is_post()) return exchange->Answer(OnlyPage("POST"));
  Call(exchange, path.substr(kCalls.size()));
}

void Api::Call(const std::shared_ptr<Exchange>& exchange, std::string_view name) {
  const Request& request = exchange->request();
  const Method* method = methods_.Find(name);
  if (method == nullptr) return exchange->Answer(ErrorPage(UnknownMethod()));
  auto token = TokenOf(request);
  if (!token.ok()) return exchange->Answer(ErrorPage(token.status()));
  auto message = FromJson(request.message.body(), *method->request);
  if (!message.ok()) return exchange->Answer(ErrorPage(message.status()));
  calls_.Begin(*method, *std::move(message), *token, exchange);
}

absl::StatusOr<Api::Query> Api::QueryOf(const Request& request, const Method& method) {
  auto token = TokenOf(request);
  if (!token.ok()) return token.status();
  const auto json = QueryValue(request.query(), "request");
  if (!json.ok()) return json.status();
  auto message = FromJson(*json, *method.request);
  if (!message.ok()) return message.status();
  return Query{*std::move(message), *std::move(token)};
}

void Api::Watch(const std::shared_ptr<Exchange>& exchange, std::string_view name) {
  const Method* method = methods_.Find(name);
  if (method == nullptr) return exchange->Answer(ErrorPage(UnknownMethod()));
  const auto query = QueryOf(exchange->request(), *method);
  if (!query.ok()) return exchange->Answer(ErrorPage(query.status()));
  topics_.Watch(exchange, *method, *query->message, query->token);
}

void Api::WriteCsv(const std::shared_ptr<Exchange>& exchange, std::string_view name) {
  const CsvKind* kind = FindCsv(name);
  if (kind == nullptr)
    return exchange->Answer(ErrorPage(absl::NotFoundError("the daemon has no table of this name")));
  const Method* method = methods_.Find(kind->method);
  if (method == nullptr) return exchange->Answer(ErrorPage(UnknownMethod()));
  auto query = QueryOf(exchange->request(), *method);
  if (!query.ok()) return exchange->Answer(ErrorPage(query.status()));
  calls_.Begin(*method, std::move(query->message), query->token, exchange, kind->make());
}

absl::StatusOr<Api::Token> Api::TokenOf(const Request& request) {
  Token token;
  const std::string_view authorization = request.Header("Authorization");
  if (absl::StartsWithIgnoreCase({authorization.data(), authorization.size()}, kScheme)) {
    token = authorization.substr(kScheme.size());
    if (!LooksLikeToken(*token))
      return absl::InvalidArgumentError(
          "the token in Authorization has invalid characters, or is too long");
  } else if (const std::string cookie = CookieOf(request); !cookie.empty()) {
    token = logins_.Find(cookie, priors::UnixNowS());
  }
  return token;
}

Page Api::LogIn(const Request& request) {
  if (!options_.asks_for_tokens())
    return ErrorPage(absl::FailedPreconditionError("this daemon does not use tokens"));
  const std::string token = TokenIn(request.message.body());
  if (!LooksLikeToken(token)) {
    return ErrorPage(absl::InvalidArgumentError(
        "expected {\"token\":\"…\"} with a token of `sweepstaked token create`"));
  }
  const auto holder = options_.identify(request.peer, token);
  if (!holder.ok()) return ErrorPage(holder.status());
  if (!auth::Includes(holder->role, auth::Role::kWatch)) {
    return ErrorPage(absl::PermissionDeniedError(
        absl::StrCat("a token of the role ", std::string(auth::NameOf(holder->role)),
                     " cannot read; log in with one of the role watch, operator or admin")));
  }
  logins_.End(CookieOf(request));
  return {.status = kNoContent,
          .headers = {SetCookie(request, logins_.Begin(token, priors::UnixNowS()))}};
}

Page Api::LogOut(const Request& request) {
  logins_.End(CookieOf(request));
  return {.status = kNoContent, .headers = {SetCookie(request, "")}};
}

Page Api::WhoAmI(const Request& request) {
  const bool asks = options_.asks_for_tokens();
  const auto token = TokenOf(request);
  if (!token.ok()) return ErrorPage(token.status());
  // A request without a token does not count as a failed login.
  const bool identifies = !asks || token->has_value();
  const auto holder = identifies ? options_.identify(request.peer, *token)
                                 : absl::StatusOr<auth::Principal>(absl::UnauthenticatedError(""));
  if (!holder.ok() && !absl::IsUnauthenticated(holder.status())) return ErrorPage(holder.status());
  // Ends a login whose token has become invalid. Otherwise each use of its cookie would count as a
  // failed login.
  const std::string cookie = CookieOf(request);
  if (!holder.ok() && token->has_value() && logins_.Find(cookie, priors::UnixNowS()) == *token)
    logins_.End(cookie);
  ordered_json answer = {{"version", options_.version}, {"asksForTokens", asks}};
  answer["loggedIn"] = asks && holder.ok();
  answer["name"] = holder.ok() ? holder->name : "";
  answer["role"] = holder.ok() ? std::string(auth::NameOf(holder->role)) : "";
  answer["stableProbability"] = options_.stable_probability;
  answer["tieLossRatio"] = options_.tie_loss_ratio;
  answer["projects"] = holder.ok() ? holder->projects : std::vector<std::string>();
  return {.body = answer.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
          .content_type = "application/json"};
}

}  // namespace sweepstake::web
