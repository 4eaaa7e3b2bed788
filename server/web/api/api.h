// The HTTP interface of the dashboard: the methods of the daemon's own services as JSON over HTTP,
// their events as server-sent events, and logins. It forwards every call to the services, which
// alone decide whether the caller may make it.
//
//   POST /api/sweepstake.v1.SERVICE/METHOD   the request as JSON; a stream has one response per
//   line GET /events/sweepstake.v1.SERVICE/METHOD?request=JSON GET /api/whoami POST /login
//   {"token":"…"} POST /logout
//
// A request carries its token as `Authorization: Bearer TOKEN`, or as the cookie that /login
// returned for it. Used on the server's thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "server/auth/principal.h"
#include "server/web/api/event_topics.h"
#include "server/web/api/logins.h"
#include "server/web/api/methods.h"
#include "server/web/api/upstream.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct ApiOptions {
  std::shared_ptr<grpc::Channel> channel;  // to the daemon's services
  std::string caller_key;                  // the metadata that names for whom a call is made
  std::vector<std::string> methods;        // those that may be called: "SERVICE/METHOD"
  // Returns whose token it is, or why it is nobody's. `caller` as UpstreamRequest::caller.
  std::function<absl::StatusOr<auth::Principal>(const std::string& caller,
                                                std::optional<std::string_view> token)>
      identify;
  std::function<bool()> asks_for_tokens;
  std::string version;  // of the daemon
  // The thresholds of verdicts, which charts draw.
  double stable_probability = 0;
  double tie_loss_ratio = 0;
  // Whether tokens are taken from other machines, though this is plain text.
  bool takes_tokens_from_afar = false;
  EventLimits events = {};
  std::shared_ptr<EventCounters> event_counters = std::make_shared<EventCounters>();
};

class Api {
 public:
  Api(ApiOptions options, boost::asio::io_context& io);

  // Answers a request that Site::Options::api gets.
  void Handle(const std::shared_ptr<Exchange>& exchange);

 private:
  using Token = std::optional<std::string>;

  void Call(const std::shared_ptr<Exchange>& exchange, std::string_view name);
  void Watch(const std::shared_ptr<Exchange>& exchange, std::string_view name);
  Page LogIn(const Request& request);
  Page LogOut(const Request& request);
  Page WhoAmI(const Request& request);
  // Returns the token that the request brings, if it brings one. Errors: INVALID_ARGUMENT (no token
  // looks so), PERMISSION_DENIED (it came in plain text, over a network).
  absl::StatusOr<Token> TokenOf(const Request& request);
  absl::Status CheckWay(const Request& request) const;

  const ApiOptions options_;
  const Methods methods_;
  Logins logins_;
  Upstream upstream_;
  EventTopics topics_;  // after the calls that it has
};

}  // namespace sweepstake::web
