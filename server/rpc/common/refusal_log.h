// Logs refused calls: at most one line per reason in ten seconds, and the number of omitted lines.
// Thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <mutex>
#include <string_view>

#include "absl/status/status.h"
#include "server/sessions/common/decision_loop.h"
#include "sweepstake/v1/errors.pb.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class RefusalLog {
 public:
  static constexpr int64_t kIntervalNs = 10'000'000'000;

  RefusalLog(const sessions::LoopClock& clock, spdlog::logger& log) : clock_(clock), log_(log) {}

  // Logs a refusal. `peer` is the caller whose call or stream was refused.
  void Tell(std::string_view peer, const absl::Status& refusal);
  // Logs the end of a call if it is a refusal. Success, a client that disconnected, a draining
  // daemon and an unknown scene are not refusals.
  void TellEnd(std::string_view peer, const absl::Status& end);
  // Logs the number of omitted lines of each reason whose ten seconds are over. Call it about once
  // per second.
  void TellLeftOut();

 private:
  struct Line {
    int64_t next_ns = std::numeric_limits<int64_t>::min();
    uint64_t left_out_count = 0;
  };

  const sessions::LoopClock& clock_;
  spdlog::logger& log_;
  std::mutex mutex_;
  std::array<Line, v1::ErrorReason_ARRAYSIZE> lines_;  // guarded by mutex_
};

}  // namespace sweepstake::rpc
