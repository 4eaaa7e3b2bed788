// Says in the log what was refused, one line for each reason in ten seconds, and how many lines
// that left out. Thread-safe.
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

  RefusalLog(const sessions::Clock& clock, spdlog::logger& log) : clock_(clock), log_(log) {}

  // `peer` is whose call or stream was refused.
  void Tell(std::string_view peer, const absl::Status& refusal);
  // As Tell, of whatever ended a call: what is no refusal is left out, which are success, a client
  // that has gone, the daemon's own end, and that nothing is known of what was asked for.
  void TellEnd(std::string_view peer, const absl::Status& end);
  // Says what was left out, once that is due. To be called every second or so.
  void TellLeftOut();

 private:
  struct Line {
    int64_t next_ns = std::numeric_limits<int64_t>::min();
    uint64_t left_out_count = 0;
  };

  const sessions::Clock& clock_;
  spdlog::logger& log_;
  std::mutex mutex_;
  std::array<Line, v1::ErrorReason_ARRAYSIZE> lines_;  // guarded by mutex_
};

}  // namespace sweepstake::rpc
