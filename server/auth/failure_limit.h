// Counts the calls with a wrong token or none, by source address, to slow down the guessing of
// tokens.
//
// Thread-safe. The memory is bounded by kMaxAddresses; above it the address whose minute began
// first is removed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

namespace sweepstake::auth {

class FailureLimit {
 public:
  static constexpr uint32_t kMaxFailures = 10;  // per address and minute
  static constexpr int64_t kIntervalNs = 60'000'000'000;
  static constexpr size_t kMaxAddresses = 10'000;

  enum class Level { kBelow, kReached, kBeyond };
  // Counts a failure. The minute of an address begins with its first failure. Returns kReached
  // once, at the last failure that is allowed.
  Level Count(const std::string& address, int64_t now_ns);

  size_t size() const;

 private:
  struct Minute {
    int64_t start_ns = 0;
    uint32_t count = 0;
  };

  void Forget(int64_t now_ns);

  mutable std::mutex mutex_;  // guards the members below
  std::unordered_map<std::string, Minute> minutes_;
  std::deque<std::pair<int64_t, std::string>> starts_;  // starts of the minutes, oldest first
};

}  // namespace sweepstake::auth
