// Warns in time of a database that nears the size that it may have, beyond which nothing more is
// acknowledged. Plain values; not thread-safe.
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

  // Takes how many bytes of the database are in use, of those that it may have. Says what to do if
  // they are more than three quarters and nothing was said for kInterval; else returns nothing.
  std::optional<std::string> Look(uint64_t used_bytes, uint64_t max_bytes, TimePoint now);

 private:
  std::optional<TimePoint> told_;  // at the latest
};

}  // namespace sweepstake::server
