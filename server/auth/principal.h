// Callers, and the interface that looks up their tokens. Plain values and an interface without I/O.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::auth {

// The permissions of a token. A token of the role kPlayer is part of a game that players have, who
// can read it. Their games send evidence, but only about scenes and arms that others have used. A
// token of the role kTicket makes no calls: it signs the tickets of players (ticket.h).
enum class Role : uint8_t { kPlayer, kTicket, kIngest, kWatch, kOperator, kAdmin };
// Names on the command line and in the database, in the order of Role.
inline constexpr std::array<std::string_view, 6> kRoleNames = {"player", "ticket",   "ingest",
                                                               "watch",  "operator", "admin"};

constexpr std::string_view NameOf(Role role) { return kRoleNames[static_cast<size_t>(role)]; }

// Returns whether a token with the role `held` may make calls that need `needed`. A player may make
// the calls of games; an operator may also watch; an admin may do everything.
constexpr bool Includes(Role held, Role needed) {
  return held == needed || held == Role::kAdmin ||
         (held == Role::kPlayer && needed == Role::kIngest) ||
         (held == Role::kOperator && needed == Role::kWatch);
}

// A caller. If the daemon has no tokens, token_id is 0, and the address decides what is allowed
// (rpc/common/access_control.h).
struct Principal {
  int64_t token_id = 0;  // from 1; never reused for another token
  std::string name;      // name of the token
  Role role = Role::kAdmin;
  std::vector<std::string> projects;  // projects that the caller may read and write; empty: all
  // SHA-256 of the token. Distinguishes the token from one with the same id in a token file that
  // has replaced the first file.
  std::string digest = {};
  std::string player = {};  // player that the caller's ticket names; empty without a ticket

  bool MayUse(std::string_view project) const {
    return projects.empty() ||
           std::find(projects.begin(), projects.end(), project) != projects.end();
  }
};

// The tokens that are valid now. Thread-safe; no call blocks.
class TokenDirectory {
 public:
  virtual ~TokenDirectory() = default;
  // Returns whether no token was ever created, so that calls need none. Revoked and expired tokens
  // count as created.
  virtual bool empty() const = 0;
  // Returns the holder of a token or ticket (ticket.h), or nothing if it is unknown or no longer
  // valid.
  virtual std::optional<Principal> Find(std::string_view token) const = 0;
  // Returns whether the holder's token is still valid.
  virtual bool IsValid(const Principal& holder) const = 0;
};

}  // namespace sweepstake::auth
