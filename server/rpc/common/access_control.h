// Decides who may call what. GenericService calls Authorize as soon as the headers of a call have
// arrived: gRPC's interceptors cannot refuse a call in C++, and its AuthMetadataProcessor does not
// run without TLS.
//
// A call carries its token as metadata: `authorization: Bearer TOKEN`. While the daemon has no
// tokens, callers on its machine may do everything, and others may send evidence and read.
//
// This class also limits the rates of reads (calls that list, export or begin to watch), of new
// streams and of bail-outs that count as evidence. It limits the numbers of exports, imports and
// watchers. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/auth/failure_limit.h"
#include "server/auth/principal.h"
#include "server/auth/rate_limit.h"
#include "server/rpc/common/options.h"
#include "server/rpc/common/refusal_log.h"
#include "server/rpc/common/role_table.h"
#include "server/sessions/common/decision_loop.h"

namespace sweepstake::rpc {

// The caller of a method, and its address.
struct Caller : auth::Principal {
  std::string peer;  // the remote address in gRPC's format
};

class AccessControl {
 public:
  // All three arguments are borrowed.
  AccessControl(const RpcOptions& options, const sessions::LoopClock& clock, spdlog::logger& log)
      : options_(options), tokens_(options.tokens), clock_(clock), refusals_(clock, log) {}

  // Returns the caller. Errors: UNAUTHENTICATED (missing or invalid token), PERMISSION_DENIED (its
  // role does not allow this RPC), RESOURCE_EXHAUSTED (too many unauthenticated calls from the
  // address, or the token or the address exceeds its rate of reads). Unauthenticated calls from an
  // address never block a valid token from the same address. Refusals are logged.
  absl::StatusOr<Caller> Authorize(const grpc::ServerContextBase& call, Rpc rpc);

  // Like Authorize, for an HTTP request. Without `rpc`, a token with any role is accepted. `peer`
  // is the remote address in gRPC's format.
  absl::StatusOr<Caller> AuthorizeOverHttp(const std::string& peer,
                                           std::optional<std::string_view> token,
                                           std::optional<Rpc> rpc) {
    return Check(peer, token, asks_over_http(), rpc);
  }

  // Returns whether calls must have tokens.
  bool asks_for_tokens() const { return tokens_ != nullptr && !tokens_->empty(); }
  // Returns whether HTTP requests must have tokens: HTTP has no client certificates, so a client CA
  // also makes tokens necessary.
  bool asks_over_http() const { return asks_for_tokens() || !options_.tls.ca.empty(); }

  // Returns an error if the caller's token was revoked or has expired since Authorize.
  absl::Status CheckStill(const auth::Principal& caller) const;

  // Counts a read against the rate limits of the token (0: none) and of the address. Authorize
  // calls it. Error: RESOURCE_EXHAUSTED (one of the limits is exceeded).
  absl::Status BeginRead(const std::string& address, int64_t token_id);

  // Counts a Hello against the rate limit of the caller's party: the player of its ticket, else the
  // network of its address, else (on the daemon's own machine, because of proxies) its token. So a
  // client that shares its token with others does not use up their rate. Without a token, the own
  // machine has no limit. Error: RESOURCE_EXHAUSTED (the limit is exceeded).
  absl::Status BeginHello(const auth::Principal& caller, const std::string& peer);

  // Counts a bail-out against the rate limit of the same party. Returns whether it is within the
  // rate of kBailingOutGames games. Only then is the bail-out evidence. More sessions do not raise
  // the limit.
  bool SpendBailOut(const auth::Principal& caller, const std::string& peer);

  // A slot that is counted until the last copy is destroyed. It may outlive the server.
  using Share = std::shared_ptr<void>;
  // Counts an export or import. Error: RESOURCE_EXHAUSTED with the reason `refusal` (the daemon or
  // the token has the maximum number of transfers).
  absl::StatusOr<Share> BeginTransfer(const auth::Principal& caller, v1::ErrorReason refusal);
  // Counts a watcher of the caller's token and of the address. Error: RESOURCE_EXHAUSTED (the
  // daemon has RpcOptions::max_watchers watchers, or the token or the address has half of that
  // number, rounded up). Addresses of the daemon's own machine are not limited.
  absl::StatusOr<Share> BeginWatch(const auth::Principal& caller, const std::string& address);

  RefusalLog& refusals() { return refusals_; }

 private:
  struct Shares {
    // Adds one to the count of each holder until the returned share is destroyed. REQUIRES: mutex
    // is locked.
    static Share Take(const std::shared_ptr<Shares>& shares, std::vector<std::string> holders);
    uint32_t Of(const std::string& holder) const;  // REQUIRES: mutex is locked

    std::mutex mutex;  // guards the members below
    uint32_t count = 0;
    std::map<std::string, uint32_t> counts;  // per holder; holders without shares are removed
  };

  // Returns the holder of the token. If `asks` is false, tokens are not needed, and the result is a
  // default Principal.
  absl::StatusOr<auth::Principal> Identify(const std::string& peer,
                                           std::optional<std::string_view> token, bool asks);
  absl::StatusOr<Caller> Check(const std::string& peer, std::optional<std::string_view> token,
                               bool asks, std::optional<Rpc> rpc);
  absl::Status CheckRole(const auth::Principal& caller, const std::string& address, Rpc rpc);
  // Counts a call against the rate limits of the token (0: none) and of the address (empty: not
  // counted). Returns a description of the token or address that exceeds the rate; empty if neither
  // does.
  std::string Count(auth::RateLimit& limit, double per_s, const std::string& address,
                    int64_t token_id);
  absl::Status Unauthenticated(const std::string& peer, bool has_token);

  const RpcOptions& options_;
  const auth::TokenDirectory* const tokens_;
  const sessions::LoopClock& clock_;
  auth::FailureLimit failures_;
  auth::RateLimit reads_;
  auth::RateLimit hellos_;
  auth::RateLimit bail_outs_;
  RefusalLog refusals_;
  const std::shared_ptr<Shares> transfers_ = std::make_shared<Shares>();
  const std::shared_ptr<Shares> watchers_ = std::make_shared<Shares>();
};

// Error: PERMISSION_DENIED (the caller's token is not valid for this project). The result does not
// depend on whether the project exists.
absl::Status CheckProject(const auth::Principal& caller, std::string_view project);

// Restricts a filter to the projects that the caller may see. Errors: those of CheckProject.
template <typename Filter>
absl::Status Narrow(const auth::Principal& caller, Filter& filter) {
  filter.projects = caller.projects;
  return filter.project.empty() ? absl::OkStatus() : CheckProject(caller, filter.project);
}

// Returns the caller's name for the log.
std::string NameForLog(const auth::Principal& caller);
// Returns the caller's name and address for the audit log; the address alone if there is no token.
std::string NameAndAddress(const Caller& caller);

}  // namespace sweepstake::rpc
