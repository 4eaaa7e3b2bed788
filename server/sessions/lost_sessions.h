// The order in which lost sessions (sessions without a connection) leave memory to make room for
// new ones. Not thread-safe; each operation takes logarithmic time.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

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
  void Add(int64_t token_id, LostRank rank, std::string session_id) {
    of_token_.emplace(std::pair(token_id, rank), session_id);
    all_.emplace(rank, std::move(session_id));
  }
  // Removes the session that was added with these arguments.
  void Remove(int64_t token_id, LostRank rank) {
    all_.erase(rank);
    of_token_.erase({token_id, rank});
  }

  // Returns the first session to leave; if `token_id` is given, the first one of that token.
  std::optional<std::string> First(std::optional<int64_t> token_id) const {
    if (!token_id) return all_.empty() ? std::nullopt : std::optional(all_.begin()->second);
    const auto first = of_token_.lower_bound({*token_id, {}});
    if (first == of_token_.end() || first->first.first != *token_id) return std::nullopt;
    return first->second;
  }

 private:
  std::map<LostRank, std::string> all_;
  std::map<std::pair<int64_t, LostRank>, std::string> of_token_;
};

}  // namespace sweepstake::sessions
