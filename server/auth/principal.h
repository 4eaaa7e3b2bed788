// Who calls, and where the callers' tokens are looked up. Plain values and an interface without
// I/O.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::auth {

// What a token is for.
enum class Role : uint8_t { kIngest, kWatch, kOperator, kAdmin };
// Their names on the command line and in the database, in the order of Role.
inline constexpr std::array<std::string_view, 4> kRoleNames = {"ingest", "watch", "operator",
                                                               "admin"};

constexpr std::string_view NameOf(Role role) { return kRoleNames[static_cast<size_t>(role)]; }

// Returns whether a token of role `held` may do what needs `needed`. An operator may watch; an
// admin may do everything.
constexpr bool Includes(Role held, Role needed) {
  return held == needed || held == Role::kAdmin ||
         (held == Role::kOperator && needed == Role::kWatch);
}

// A caller. That of a daemon without tokens has no token's id and may do everything.
struct Principal {
  int64_t token_id = 0;  // from 1; never used again for another token
  std::string name;      // of the token
  Role role = Role::kAdmin;
  std::vector<std::string> projects;  // those it may see and write; empty: all
  // Tells the token from one of the same id in another file that was put in the place of the first.
  std::string digest = {};

  bool MayUse(std::string_view project) const {
    return projects.empty() ||
           std::find(projects.begin(), projects.end(), project) != projects.end();
  }
};

// The tokens that are valid now. Thread-safe; nothing in it waits.
class TokenDirectory {
 public:
  virtual ~TokenDirectory() = default;
  // Returns whether no token was ever made, so that nobody is asked for one. Tokens that are
  // revoked or have expired count.
  virtual bool empty() const = 0;
  // Returns the token's holder, or nothing if there is no such token, or it is not valid any more.
  virtual std::optional<Principal> Find(std::string_view token) const = 0;
  // Returns whether the holder's token is still valid.
  virtual bool IsValid(const Principal& holder) const = 0;
};

}  // namespace sweepstake::auth
