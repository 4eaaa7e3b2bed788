// Warns before a database reaches its maximum size, at which the store stops acknowledging
// evidence. Plain values; not thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace sweepstake::server {

class SpaceWarning {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::hours kInterval{1};

  // Returns a warning if more than three quarters of the maximum size are in use, and the last
  // warning is at least kInterval old.
  std::optional<std::string> Look(uint64_t used_bytes, uint64_t max_bytes, TimePoint now);

 private:
  std::optional<TimePoint> warned_;  // time of the last warning
};

}  // namespace sweepstake::server
