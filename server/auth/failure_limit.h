// Counts the calls that came with a wrong token or none, by the address they came from, so that
// one that guesses is told to wait.
//
// Thread-safe. The memory is bounded by kMaxAddresses; beyond it the address whose count is the
// oldest is forgotten.
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
  static constexpr uint32_t kMaxFailures = 10;  // of an address in a minute
  static constexpr int64_t kIntervalNs = 60'000'000'000;
  static constexpr size_t kMaxAddresses = 10'000;

  enum class Verdict { kBelow, kReached, kBeyond };
  // Counts a failure. The minute of an address begins with its first one. Returns kReached once, at
  // the last failure that is allowed.
  Verdict Count(const std::string& address, int64_t now_ns);

  size_t size() const;

 private:
  struct Window {
    int64_t start_ns = 0;
    uint32_t count = 0;
  };

  void Forget(int64_t now_ns);

  mutable std::mutex mutex_;  // guards what follows
  std::unordered_map<std::string, Window> windows_;
  std::deque<std::pair<int64_t, std::string>> starts_;  // of the windows, oldest first
};

}  // namespace sweepstake::auth
