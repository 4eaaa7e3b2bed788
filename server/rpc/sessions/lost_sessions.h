// Which lost session leaves memory next where there is no room. Not thread-safe; each operation
// takes logarithmic time.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace sweepstake::rpc {

// In the order in which they leave: first those whose evidence is on disk, the one that was lost
// first before the others.
struct LostRank {
  bool unsettled = false;
  uint64_t number = 0;  // of the loss, unique

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const LostRank&, const LostRank&) = default;
};

class LostSessions {
 public:
  void Add(int64_t token_id, LostRank rank, std::string session_id) {
    of_token_.emplace(std::pair(token_id, rank), session_id);
    all_.emplace(rank, std::move(session_id));
  }
  // Removes the session if it is there, settled or not.
  void Remove(int64_t token_id, uint64_t number) {
    for (const bool unsettled : {false, true}) {
      all_.erase({unsettled, number});
      of_token_.erase({token_id, {unsettled, number}});
    }
  }

  // Returns the first one, of the token if one is given.
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

}  // namespace sweepstake::rpc
