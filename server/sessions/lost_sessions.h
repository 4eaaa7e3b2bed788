// The order in which lost sessions (sessions without a connection) leave memory to make room for
// new ones. Not thread-safe; each operation takes logarithmic time.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

// Whether a lost session has evidence that is not on disk. Sessions with a smaller value leave
// first.
enum class LostState : uint8_t {
  kSettled,    // all evidence is on disk
  kUnsettled,  // some evidence is not on disk; the client will resend it
  // Not all evidence is on disk, and no client will resend it: the session stays until all is.
  kEnding,
};

// The rank of a lost session. Sessions with the smallest rank leave memory first: by state, then by
// the time at which they lost their connections.
struct LostRank {
  LostState state = LostState::kSettled;
  uint64_t number = 0;  // unique; grows with each lost connection

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const LostRank&, const LostRank&) = default;
};

class LostSessions {
 public:
  using Owner = priors::SourceOrigin::Owner;

  void Add(const Owner& owner, LostRank rank, std::string session_id) {
    of_owner_.emplace(std::pair(owner, rank), session_id);
    all_.emplace(rank, std::move(session_id));
  }
  // Removes the session that was added with these arguments.
  void Remove(const Owner& owner, LostRank rank) {
    all_.erase(rank);
    of_owner_.erase({owner, rank});
  }

  // Returns the first `count` sessions to leave, or fewer if there are fewer; if `owner` is given,
  // those of that owner.
  std::vector<std::string> First(const std::optional<Owner>& owner, size_t count) const {
    std::vector<std::string> first;
    if (!owner) {
      for (auto next = all_.begin(); next != all_.end() && first.size() < count; ++next)
        first.push_back(next->second);
      return first;
    }
    for (auto next = of_owner_.lower_bound({*owner, {}});
         next != of_owner_.end() && next->first.first == *owner && first.size() < count; ++next)
      first.push_back(next->second);
    return first;
  }

 private:
  std::map<LostRank, std::string> all_;
  std::map<std::pair<Owner, LostRank>, std::string> of_owner_;
};

}  // namespace sweepstake::sessions
