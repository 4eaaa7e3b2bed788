// Who may call what. Every handler calls Authorize first: gRPC's interceptors cannot refuse a call
// in C++, and its AuthMetadataProcessor does not run without TLS.
//
// A call brings its token as metadata: `authorization: Bearer TOKEN`. While the daemon has no
// tokens everybody may do everything. How often somebody may read or begin a stream is counted
// here, too, how often a bail-out is evidence, and how many exports, imports and watchers there
// are. Thread-safe.
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

class AccessControl {
 public:
  // It borrows all three.
  AccessControl(const RpcOptions& options, const sessions::Clock& clock, spdlog::logger& log)
      : options_(options), tokens_(options.tokens), clock_(clock), refusals_(clock, log) {}

  // Returns who calls. Errors: UNAUTHENTICATED (no token, or one that is not valid),
  // PERMISSION_DENIED (its role does not allow this RPC), RESOURCE_EXHAUSTED (too many calls from
  // the address were not authenticated, or the token or the address reads too often). A valid token
  // is never refused for calls without one from its address. What is refused is told in the log.
  absl::StatusOr<auth::Principal> Authorize(const grpc::ServerContextBase& call, Rpc rpc);

  // Returns whose token somebody brings by HTTP, with the errors that Authorize has whatever the
  // role. `caller` is who it is, as gRPC names the other end.
  absl::StatusOr<auth::Principal> IdentifyOverHttp(const std::string& caller,
                                                   std::optional<std::string_view> token);

  // Returns whether calls must bring tokens.
  bool asks_for_tokens() const { return tokens_ != nullptr && !tokens_->empty(); }
  // The same of what comes by HTTP, which asks nobody for a certificate.
  bool asks_over_http() const { return asks_for_tokens() || !options_.tls.ca.empty(); }

  // Returns whether the caller may still go on: its token has not been revoked and has not expired
  // since Authorize.
  absl::Status CheckStill(const auth::Principal& caller) const;

  // Counts a call that reads, of a token (0: none) at an address, for Authorize. Error:
  // RESOURCE_EXHAUSTED.
  absl::Status BeginRead(const std::string& address, int64_t token_id);

  // Counts a Hello likewise, but no address of the daemon's own machine.
  absl::Status BeginHello(const std::string& address, int64_t token_id);

  // Counts a bail-out as a Hello is counted. Returns whether it is evidence: a client that begins
  // one session after the other has no more of them than kBailingOutGames.
  bool SpendBailOut(const std::string& address, int64_t token_id);

  // What is counted as long as this lives. It may outlive the server.
  using Share = std::shared_ptr<void>;
  // Counts an export or import. Error: RESOURCE_EXHAUSTED (the daemon or the token has as many as
  // it may); its reason is `refusal`.
  absl::StatusOr<Share> BeginTransfer(const auth::Principal& caller, v1::ErrorReason refusal);
  // Counts one who watches, at an address. Error: RESOURCE_EXHAUSTED (the token, or the address
  // unless it is of the daemon's own machine, has half of RpcOptions::max_watchers, rounded up).
  absl::StatusOr<Share> BeginWatch(const auth::Principal& caller, const std::string& address);

  RefusalLog& refusals() { return refusals_; }

 private:
  struct Shares {
    // Counts one for each of the holders until what it returns ends. REQUIRES: mutex is locked.
    static Share Take(const std::shared_ptr<Shares>& shares, std::vector<std::string> holders);
    uint32_t Of(const std::string& holder) const;  // REQUIRES: mutex is locked

    std::mutex mutex;  // guards what follows
    uint32_t count = 0;
    std::map<std::string, uint32_t> counts;  // of those that have any
  };

  // Returns whose token it is, or somebody who needs none.
  absl::StatusOr<auth::Principal> Identify(const std::string& caller,
                                           std::optional<std::string_view> token, bool asks);
  absl::Status CheckRole(const auth::Principal& caller, const std::string& address, Rpc rpc);
  // Counts what the token (0: none) at the address (empty: not counted) does. Returns who does it
  // too often; empty if neither does.
  std::string Count(auth::RateLimit& limit, double per_s, const std::string& address,
                    int64_t token_id);
  // As Count, but an address of the daemon's own machine is not counted: all games of a proxy on it
  // have this one.
  std::string CountGame(auth::RateLimit& limit, double per_s, const std::string& address,
                        int64_t token_id);
  absl::Status Unauthenticated(const std::string& caller, bool has_token);

  const RpcOptions& options_;
  const auth::TokenDirectory* const tokens_;
  const sessions::Clock& clock_;
  auth::FailureLimit failures_;
  auth::RateLimit reads_;
  auth::RateLimit hellos_;
  auth::RateLimit bail_outs_;
  RefusalLog refusals_;
  const std::shared_ptr<Shares> transfers_ = std::make_shared<Shares>();
  const std::shared_ptr<Shares> watchers_ = std::make_shared<Shares>();
};

// Error: PERMISSION_DENIED (the caller's token is not for this project), whether the project exists
// or not.
absl::Status CheckProject(const auth::Principal& caller, std::string_view project);

// Narrows a filter to what the caller may see. Errors: those of CheckProject.
template <typename Filter>
absl::Status Narrow(const auth::Principal& caller, Filter& filter) {
  filter.projects = caller.projects;
  return filter.project.empty() ? absl::OkStatus() : CheckProject(caller, filter.project);
}

// The metadata in which the daemon's HTTP side says for whom it makes a call, as gRPC names the
// other end. Of other callers it counts for nothing.
inline constexpr char kCallerKey[] = "sweepstake-caller";
// Returns who is at the other end of a call, as gRPC names it: of one that the daemon's HTTP side
// makes, for whom that is.
std::string CallerOf(const grpc::ServerContextBase& call);

// Returns the caller's name for the log.
std::string NameForLog(const auth::Principal& caller);
// Returns who and where the caller is, for the audit log: without a token it is the address alone.
std::string NameAndAddress(const auth::Principal& caller, const grpc::ServerContextBase& call);

// A streaming call that is refused at once.
template <typename Reactor>
class RefusedCall final : public Reactor {
 public:
  explicit RefusedCall(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace sweepstake::rpc
