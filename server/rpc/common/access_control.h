// Who may call what. Every handler calls Authorize first: gRPC's interceptors cannot refuse a call
// in C++, and its AuthMetadataProcessor does not run without TLS.
//
// A call brings its token as metadata: `authorization: Bearer TOKEN`. While the daemon has no
// tokens everybody may do everything. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/auth/failure_limit.h"
#include "server/auth/principal.h"
#include "server/rpc/common/decision_loop.h"
#include "server/rpc/common/role_table.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class AccessControl {
 public:
  // `tokens` may be null: then there are none.
  AccessControl(const auth::TokenDirectory* tokens, const Clock& clock, spdlog::logger& log)
      : tokens_(tokens), clock_(clock), log_(log) {}

  // Returns who calls. Errors: UNAUTHENTICATED (no token, or one that is not valid),
  // PERMISSION_DENIED (its role does not allow this RPC), RESOURCE_EXHAUSTED (too many calls from
  // the address were not authenticated). A valid token is never refused for what others at its
  // address did.
  absl::StatusOr<auth::Principal> Authorize(const grpc::ServerContextBase& call, Rpc rpc);

  // Returns whether calls must bring tokens.
  bool asks_for_tokens() const { return tokens_ != nullptr && !tokens_->empty(); }

  // Returns whether the caller may still go on: its token has not been revoked and has not expired
  // since Authorize.
  absl::Status CheckStill(const auth::Principal& caller) const;

 private:
  absl::Status Unauthenticated(const grpc::ServerContextBase& call, bool has_token);

  const auth::TokenDirectory* const tokens_;
  const Clock& clock_;
  spdlog::logger& log_;
  auth::FailureLimit failures_;
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

// Returns the caller's name for the log.
std::string NameForLog(const auth::Principal& caller);

// A streaming call that is refused at once.
template <typename Reactor>
class RefusedCall final : public Reactor {
 public:
  explicit RefusedCall(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace sweepstake::rpc
