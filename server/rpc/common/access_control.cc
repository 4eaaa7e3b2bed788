#include "server/rpc/common/access_control.h"

#include <spdlog/logger.h>

#include <iterator>
#include <optional>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/decision/math/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/peer_address.h"

namespace sweepstake::rpc {
namespace {

constexpr absl::string_view kScheme = "Bearer ";

// Returns the call's token; absent if there is none, or more than one.
std::optional<std::string_view> TokenOf(const grpc::ServerContextBase& call) {
  const auto [first, last] = call.client_metadata().equal_range("authorization");
  if (first == last || std::next(first) != last) return std::nullopt;
  const std::string_view value(first->second.data(), first->second.size());
  if (!absl::StartsWithIgnoreCase({value.data(), value.size()}, kScheme)) return std::nullopt;
  return value.substr(kScheme.size());
}

}  // namespace

absl::StatusOr<auth::Principal> AccessControl::Authorize(const grpc::ServerContextBase& call,
                                                         Rpc rpc) {
  if (!asks_for_tokens()) return auth::Principal{};
  const std::optional<std::string_view> token = TokenOf(call);
  std::optional<auth::Principal> caller;
  if (token) caller = tokens_->Find(*token);
  if (!caller) return Unauthenticated(call, token.has_value());
  if (auth::Includes(caller->role, rpc.role)) return *std::move(caller);
  return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                 absl::StrCat("this needs a token of the role ", std::string(NameOf(rpc.role)),
                              "; yours has the role ", std::string(NameOf(caller->role))));
}

absl::Status AccessControl::Unauthenticated(const grpc::ServerContextBase& call, bool has_token) {
  const std::string address = AddressOf(call.peer());
  const auto verdict = failures_.Count(address, clock_.NowNs());
  if (verdict == auth::FailureLimit::Verdict::kReached) {
    log_.warn("{} calls from {} had no valid token within a minute; the next ones are told to wait",
              auth::FailureLimit::kMaxFailures, address);
  }
  if (verdict == auth::FailureLimit::Verdict::kBeyond) {
    return Refused(v1::ERROR_REASON_TOO_MANY_FAILURES,
                   absl::StrCat("more than ", auth::FailureLimit::kMaxFailures,
                                " calls in a minute had no valid token; call with one, or wait"));
  }
  if (has_token) {
    return Refused(v1::ERROR_REASON_TOKEN_REFUSED,
                   "this token is unknown, was revoked or has expired; use another one");
  }
  return Refused(v1::ERROR_REASON_TOKEN_MISSING,
                 "this daemon asks for a token (authorization: Bearer TOKEN); `sweepstaked token "
                 "create` makes one");
}

absl::Status AccessControl::CheckStill(const auth::Principal& caller) const {
  if (!asks_for_tokens() || tokens_->IsValid(caller.token_id)) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TOKEN_REFUSED,
                 "this token was revoked or has expired; use another one");
}

absl::Status CheckProject(const auth::Principal& caller, std::string_view project) {
  if (caller.MayUse(project)) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                 "this token is not for that project; use one that is");
}

std::string NameForLog(const auth::Principal& caller) {
  return caller.token_id == 0 ? "somebody without a token"
                              : absl::StrCat("token ", math::PrintableLine(caller.name));
}

}  // namespace sweepstake::rpc
