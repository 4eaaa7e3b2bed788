#include "server/rpc/common/access_control.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "engine_client/text/names.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {
namespace {

constexpr absl::string_view kScheme = "Bearer ";

// Returns the token in the call's metadata; absent if there is none, or more than one.
std::optional<std::string_view> TokenOf(const grpc::ServerContextBase& call) {
  const auto [first, last] = call.client_metadata().equal_range("authorization");
  if (first == last || std::next(first) != last) return std::nullopt;
  const std::string_view value(first->second.data(), first->second.size());
  if (!absl::StartsWithIgnoreCase({value.data(), value.size()}, kScheme)) return std::nullopt;
  return value.substr(kScheme.size());
}

// Returns the last header x-forwarded-for of the call; empty if it has none.
std::string_view ForwardedFor(const grpc::ServerContextBase& call) {
  const auto [first, last] = call.client_metadata().equal_range("x-forwarded-for");
  if (first == last) return {};
  const grpc::string_ref value = std::prev(last)->second;
  return {value.data(), value.size()};
}

// Returns the key of a token in the rate limits and in Shares.
std::string HolderOf(int64_t token_id) { return absl::StrCat("token ", token_id); }

// Returns the party of a game, as the key of a rate limit and for messages; empty if the game has
// no limit.
std::string PartyOf(const auth::Principal& caller, const std::string& peer) {
  if (!caller.player.empty())
    return absl::StrCat("the player ", caller.player, " of ", HolderOf(caller.token_id));
  const std::string network = net::NetworkOf(peer);
  if (!network.empty()) return absl::StrCat("the network ", network);
  return caller.token_id == 0 ? "" : HolderOf(caller.token_id);
}

}  // namespace

absl::StatusOr<Caller> AccessControl::Authorize(const grpc::ServerContextBase& call, Rpc rpc) {
  std::string peer = net::ClientOf(call.peer());
  if (options_.trusts_proxy) peer = net::ForwardedPeer(peer, ForwardedFor(call));
  return Check(peer, TokenOf(call), asks_for_tokens(), rpc);
}

absl::StatusOr<Caller> AccessControl::Check(const std::string& peer,
                                            std::optional<std::string_view> token, bool asks,
                                            std::optional<Rpc> rpc) {
  auto holder = Identify(peer, token, asks);
  if (holder.ok() && rpc) {
    const absl::Status allowed = CheckRole(*holder, net::AddressOf(peer), *rpc);
    if (!allowed.ok()) holder = allowed;
  }
  if (holder.ok()) return Caller{*std::move(holder), peer};
  refusals_.Tell(peer, holder.status());
  return holder.status();
}

absl::StatusOr<auth::Principal> AccessControl::Identify(const std::string& peer,
                                                        std::optional<std::string_view> token,
                                                        bool asks) {
  if (!asks) return auth::Principal{};
  std::optional<auth::Principal> holder;
  if (token && tokens_ != nullptr) holder = tokens_->Find(*token);
  if (!holder) return Unauthenticated(peer, token.has_value());
  return *std::move(holder);
}

absl::Status AccessControl::CheckRole(const auth::Principal& caller, const std::string& address,
                                      Rpc rpc) {
  if (caller.token_id == 0 && rpc.role == auth::Role::kOperator &&
      !net::IsLoopbackAddress(address)) {
    return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                   "without a token this call is for programs on the daemon's machine only; create "
                   "a token with `sweepstaked token create`");
  }
  if (auth::Includes(caller.role, rpc.role)) {
    const bool is_game = rpc.role == auth::Role::kIngest;
    return is_game ? absl::OkStatus() : BeginRead(address, caller.token_id);
  }
  return Refused(
      v1::ERROR_REASON_NOT_ALLOWED,
      absl::StrCat("this call needs a token with the role ", std::string(NameOf(rpc.role)),
                   "; this token has the role ", std::string(NameOf(caller.role))));
}

absl::Status AccessControl::Unauthenticated(const std::string& peer, bool has_token) {
  const std::string address = net::AddressOf(peer);
  const auto level = failures_.Count(address, clock_.NowNs());
  const absl::Status beyond = Refused(
      v1::ERROR_REASON_TOO_MANY_FAILURES,
      absl::StrCat(
          "more than ", auth::FailureLimit::kMaxFailures,
          " calls from this address had no valid token within a minute; use a valid one, or wait"));
  if (level == auth::FailureLimit::Level::kReached) refusals_.Tell(address, beyond);
  if (level == auth::FailureLimit::Level::kBeyond) return beyond;
  if (has_token) {
    return Refused(v1::ERROR_REASON_TOKEN_REFUSED,
                   "this token is unknown, was revoked or has expired; use another one");
  }
  return Refused(v1::ERROR_REASON_TOKEN_MISSING,
                 "this daemon requires a token (--token-file for commands, `authorization: Bearer "
                 "TOKEN` for other programs); create one with `sweepstaked token create`");
}

std::string AccessControl::Count(auth::RateLimit& limit, double per_s, const std::string& address,
                                 int64_t token_id) {
  const int64_t now_ns = clock_.NowNs();
  if (!address.empty() && !limit.Take(address, per_s, now_ns))
    return absl::StrCat("the address ", address);
  const bool allowed = token_id == 0 || limit.Take(HolderOf(token_id), per_s, now_ns);
  return allowed ? "" : "this token";
}

bool AccessControl::SpendBailOut(const auth::Principal& caller, const std::string& peer) {
  const double per_s_of_game = 1e9 / static_cast<double>(options_.decision.bail_out_ns);
  const double per_s = std::max(kMinBailOutsPerS, kBailingOutGames * per_s_of_game);
  const std::string party = PartyOf(caller, peer);
  return party.empty() || bail_outs_.Take(party, per_s, clock_.NowNs());
}

absl::Status AccessControl::BeginHello(const auth::Principal& caller, const std::string& peer) {
  const uint32_t per_s = options_.max_hellos_per_s;
  const std::string party = PartyOf(caller, peer);
  if (party.empty() || hellos_.Take(party, per_s, clock_.NowNs())) return absl::OkStatus();
  return Refused(
      v1::ERROR_REASON_TOO_MANY_HELLOS,
      absl::StrCat(party, " starts more than ", per_s,
                   " streams per second (max_hellos_per_s; bursts of ten times this are allowed); "
                   "connect again in ten seconds, or raise the limit on the daemon"));
}

absl::Status AccessControl::BeginRead(const std::string& address, int64_t token_id) {
  const uint32_t per_s = options_.max_reads_per_s;
  const std::string who = Count(reads_, per_s, address, token_id);
  if (who.empty()) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TOO_MANY_READS,
                 absl::StrCat(who, " calls more often than ", per_s,
                              " times per second (max_reads_per_s); try again in a second"));
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
                              " of them with this token; the limit max_transfers or "
                              "max_transfers_per_token is reached; try again later"));
  }
  return Shares::Take(transfers_, std::move(holders));
}

absl::StatusOr<AccessControl::Share> AccessControl::BeginWatch(const auth::Principal& caller,
                                                               const std::string& address) {
  std::vector<std::string> holders;
  if (caller.token_id != 0) holders.push_back(HolderOf(caller.token_id));
  // Loopback addresses are not limited, because all watchers behind a proxy on this machine have
  // the same address.
  if (!address.empty() && !net::IsLoopbackAddress(address)) holders.push_back(address);
  const uint32_t most = (options_.max_watchers + 1) / 2;
  const std::lock_guard lock(watchers_->mutex);
  if (watchers_->count >= options_.max_watchers) {
    return Refused(
        v1::ERROR_REASON_TOO_MANY_WATCHERS,
        "this daemon has the maximum number of watchers (max_watchers); try again later");
  }
  for (const std::string& holder : holders) {
    if (const uint32_t held = watchers_->Of(holder); held >= most) {
      return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                     absl::StrCat(holder == address ? "this address" : "this token", " has ", held,
                                  " watchers, the maximum (half of max_watchers); "
                                  "end some, or raise max_watchers on the daemon"));
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
  if (project.empty()) {
    return Refused(v1::ERROR_REASON_NOT_ALLOWED,
                   "this token is valid for certain projects only; name one of them (--project)");
  }
  return Refused(
      v1::ERROR_REASON_NOT_ALLOWED,
      absl::StrCat("this token is not valid for the project ", text::PrintableLine(project),
                   "; use a token that is (`sweepstaked token create --project`)"));
}

std::string NameForLog(const auth::Principal& caller) {
  return caller.token_id == 0 ? "a caller without a token"
                              : absl::StrCat("token ", text::PrintableLine(caller.name));
}

std::string NameAndAddress(const Caller& caller) {
  if (caller.token_id == 0) return caller.peer;
  return absl::StrCat(NameForLog(caller), " at ", caller.peer);
}

}  // namespace sweepstake::rpc
