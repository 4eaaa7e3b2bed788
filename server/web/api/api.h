// The HTTP interface of the dashboard: the methods of the daemon's services as JSON, the events of
// the event bus (events/event_bus.h) as server-sent events, and logins. The services check the
// permissions of every call.
//
//   POST /api/sweepstake.v1.SERVICE/METHOD     body: the request as JSON; a stream has one response
//                                              per line
//   GET  /events/sweepstake.v1.SERVICE/METHOD?request=JSON
//   GET  /csv/TABLE?request=JSON               csv/csv_tables.h has the tables and their methods
//   GET  /api/whoami
//   POST /login                                body: {"token":"…"}
//   POST /logout
//
// A request sends its token in `Authorization: Bearer TOKEN`, or the cookie that /login returned.
// Used on the server's thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "server/auth/principal.h"
#include "server/web/api/calls.h"
#include "server/web/api/event_topics.h"
#include "server/web/api/logins.h"
#include "server/web/api/methods.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct ApiOptions {
  std::vector<std::string> methods;  // the methods that may be called: "SERVICE/METHOD"
  BeginCall begin_call;              // thread-safe
  // Returns the holder of the token, or an error. `peer` is the client's address in gRPC's format.
  std::function<absl::StatusOr<auth::Principal>(const std::string& peer,
                                                std::optional<std::string_view> token)>
      identify;
  std::function<bool()> asks_for_tokens;
  std::string version;  // the version of the daemon
  // Thresholds of the verdicts "stable" and "tie", which the dashboard shows in charts.
  double stable_probability = 0;
  double tie_loss_ratio = 0;
  BeginWatch begin_watch;   // thread-safe
  PostToLoop post_to_loop;  // thread-safe
  EventLimits events = {};
  std::shared_ptr<EventCounters> event_counters = std::make_shared<EventCounters>();
};

class Api {
 public:
  Api(ApiOptions options, boost::asio::io_context& io);

  // Answers a request that Site passes to Site::Options::api.
  void Handle(const std::shared_ptr<Exchange>& exchange);

 private:
  using Token = std::optional<std::string>;
  // What a GET request asks for.
  struct Query {
    std::unique_ptr<google::protobuf::Message> message;
    Token token;
  };

  void Call(const std::shared_ptr<Exchange>& exchange, std::string_view name);
  void Watch(const std::shared_ptr<Exchange>& exchange, std::string_view name);
  void WriteCsv(const std::shared_ptr<Exchange>& exchange, std::string_view name);
  Page LogIn(const Request& request);
  Page LogOut(const Request& request);
  Page WhoAmI(const Request& request);
  // Returns the message in the request's query, and its token. Error: INVALID_ARGUMENT.
  absl::StatusOr<Query> QueryOf(const Request& request, const Method& method);
  // Returns the token of the request, if there is one. Error: INVALID_ARGUMENT (it cannot be a
  // token).
  absl::StatusOr<Token> TokenOf(const Request& request);

  const ApiOptions options_;
  const Methods methods_;
  Logins logins_;
  Calls calls_;
  EventTopics topics_;
};

}  // namespace sweepstake::web
