#include "server/rpc/common/access_control.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

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

// Returns what a token is counted by, beside addresses.
std::string HolderOf(int64_t token_id) { return absl::StrCat("token ", token_id); }

}  // namespace

absl::StatusOr<auth::Principal> AccessControl::Authorize(const grpc::ServerContextBase& call,
                                                         Rpc rpc) {
  auto caller = Identify(call, rpc);
  if (!caller.ok()) refusals_.Tell(call.peer(), caller.status());
  return caller;
}

absl::StatusOr<auth::Principal> AccessControl::Identify(const grpc::ServerContextBase& call,
                                                        Rpc rpc) {
  std::optional<auth::Principal> caller = auth::Principal{};
  if (asks_for_tokens()) {
    const std::optional<std::string_view> token = TokenOf(call);
    caller = token ? tokens_->Find(*token) : std::nullopt;
    if (!caller) return Unauthenticated(call, token.has_value());
  }
  if (auth::Includes(caller->role, rpc.role)) {
    absl::Status allowed;
    if (rpc.role == auth::Role::kWatch)
      allowed = BeginRead(AddressOf(call.peer()), caller->token_id);
    if (!allowed.ok()) return allowed;
    return *std::move(caller);
  }
  return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                 absl::StrCat("this needs a token of the role ", std::string(NameOf(rpc.role)),
                              "; yours has the role ", std::string(NameOf(caller->role))));
}

absl::Status AccessControl::Unauthenticated(const grpc::ServerContextBase& call, bool has_token) {
  const std::string address = AddressOf(call.peer());
  const auto verdict = failures_.Count(address, clock_.NowNs());
  const absl::Status beyond =
      Refused(v1::ERROR_REASON_TOO_MANY_FAILURES,
              absl::StrCat("more than ", auth::FailureLimit::kMaxFailures,
                           " calls in a minute had no valid token; call with one, or wait"));
  if (verdict == auth::FailureLimit::Verdict::kReached) refusals_.Tell(address, beyond);
  if (verdict == auth::FailureLimit::Verdict::kBeyond) return beyond;
  if (has_token) {
    return Refused(v1::ERROR_REASON_TOKEN_REFUSED,
                   "this token is unknown, was revoked or has expired; use another one");
  }
  return Refused(v1::ERROR_REASON_TOKEN_MISSING,
                 "this daemon asks for a token (--token-file of a command, authorization: Bearer "
                 "TOKEN of another program); `sweepstaked token create` makes one");
}

std::string AccessControl::Count(auth::RateLimit& limit, double per_s, const std::string& address,
                                 int64_t token_id) {
  const int64_t now_ns = clock_.NowNs();
  if (!address.empty() && !limit.Take(address, per_s, now_ns))
    return absl::StrCat("the address ", address);
  const bool allowed = token_id == 0 || limit.Take(HolderOf(token_id), per_s, now_ns);
  return allowed ? "" : "this token";
}

std::string AccessControl::CountGame(auth::RateLimit& limit, double per_s,
                                     const std::string& address, int64_t token_id) {
  return Count(limit, per_s, IsLoopbackAddress(address) ? "" : address, token_id);
}

bool AccessControl::SpendBailOut(const std::string& address, int64_t token_id) {
  const double per_s_of_game = 1e9 / static_cast<double>(options_.decision.bail_out_ns);
  const double per_s = std::max(kMinBailOutsPerS, kBailingOutGames * per_s_of_game);
  return CountGame(bail_outs_, per_s, address, token_id).empty();
}

absl::Status AccessControl::BeginHello(const std::string& address, int64_t token_id) {
  const uint32_t per_s = options_.max_hellos_per_s;
  const std::string who = CountGame(hellos_, per_s, address, token_id);
  if (who.empty()) return absl::OkStatus();
  return Refused(
      v1::ERROR_REASON_TOO_MANY_HELLOS,
      absl::StrCat(who, " begins more than ", per_s,
                   " streams a second, and ten times as many at once "
                   "(max_hellos_per_s); connect again in ten seconds, or raise it on the "
                   "daemon"));
}

absl::Status AccessControl::BeginRead(const std::string& address, int64_t token_id) {
  const uint32_t per_s = options_.max_reads_per_s;
  const std::string who = Count(reads_, per_s, address, token_id);
  if (who.empty()) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TOO_MANY_READS,
                 absl::StrCat(who, " reads more often than ", per_s,
                              " times a second (max_reads_per_s); ask again in a second"));
}

AccessControl::Share AccessControl::Shares::Take(const std::shared_ptr<Shares>& shares,
                                                 std::vector<std::string> holders) {
  ++shares->count;
  for (const std::string& holder : holders) ++shares->counts[holder];
  return Share(nullptr, [shares, holders = std::move(holders)](void*) {
    const std::lock_guard ending(shares->mutex);
    --shares->count;
    for (const std::string& holder : holders) {
      if (--shares->counts.at(holder) == 0) shares->counts.erase(holder);
    }
  });
}

uint32_t AccessControl::Shares::Of(const std::string& holder) const {
  const auto found = counts.find(holder);
  return found == counts.end() ? 0 : found->second;
}

absl::StatusOr<AccessControl::Share> AccessControl::BeginTransfer(const auth::Principal& caller,
                                                                  v1::ErrorReason refusal) {
  std::vector<std::string> holders;
  if (caller.token_id != 0) holders.push_back(HolderOf(caller.token_id));
  const std::lock_guard lock(transfers_->mutex);
  const uint32_t own_count = holders.empty() ? 0 : transfers_->Of(holders.front());
  if (transfers_->count >= options_.max_transfers ||
      (caller.token_id != 0 && own_count >= options_.max_transfers_per_token)) {
    return Refused(
        refusal, absl::StrCat(transfers_->count, " exports and imports are under way, ", own_count,
                              " of this token, which is as many as there may be "
                              "(max_transfers, max_transfers_per_token); try again later"));
  }
  return Shares::Take(transfers_, std::move(holders));
}

absl::StatusOr<AccessControl::Share> AccessControl::BeginWatch(const auth::Principal& caller,
                                                               const std::string& address) {
  std::vector<std::string> holders;
  if (caller.token_id != 0) holders.push_back(HolderOf(caller.token_id));
  // All who watch through a proxy on this machine have this address.
  if (!address.empty() && !IsLoopbackAddress(address)) holders.push_back(address);
  const uint32_t most = (options_.max_watchers + 1) / 2;
  const std::lock_guard lock(watchers_->mutex);
  for (const std::string& holder : holders) {
    if (const uint32_t held = watchers_->Of(holder); held >= most) {
      return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                     absl::StrCat(holder == address ? "this address" : "this token", " has ", held,
                                  " watchers, half of what the daemon may have (max_watchers); "
                                  "end some, or raise it on the daemon"));
    }
  }
  return Shares::Take(watchers_, std::move(holders));
}

absl::Status AccessControl::CheckStill(const auth::Principal& caller) const {
  if (!asks_for_tokens() || tokens_->IsValid(caller)) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TOKEN_REFUSED,
                 "this token was revoked or has expired; use another one");
}

absl::Status CheckProject(const auth::Principal& caller, std::string_view project) {
  if (caller.MayUse(project)) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                 absl::StrCat("this token is not for the project ", math::PrintableLine(project),
                              "; use one that is (`sweepstaked token create --project`)"));
}

std::string NameForLog(const auth::Principal& caller) {
  return caller.token_id == 0 ? "somebody without a token"
                              : absl::StrCat("token ", math::PrintableLine(caller.name));
}

std::string NameAndAddress(const auth::Principal& caller, const grpc::ServerContextBase& call) {
  return caller.token_id == 0 ? call.peer() : absl::StrCat(NameForLog(caller), " at ", call.peer());
}

}  // namespace sweepstake::rpc
