// The order in which lost sessions leave memory to make room. Not thread-safe; each operation takes
// logarithmic time.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace sweepstake::sessions {

// Evidence of a lost session that is not on disk, in the order in which sessions leave.
enum class LostState : uint8_t {
  kSettled,    // no such evidence
  kUnsettled,  // evidence that the client will resend
  kEnding,     // evidence that no client will resend: the session stays until it is on disk
};

// Within a state, the session that was lost first leaves first.
struct LostRank {
  LostState state = LostState::kSettled;
  uint64_t number = 0;  // number of the loss, unique

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
