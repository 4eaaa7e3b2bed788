#include "server/rpc/common/refusal_log.h"

#include <spdlog/logger.h>

#include <string>
#include <utility>

#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

void RefusalLog::Tell(std::string_view peer, const absl::Status& refusal) {
  const v1::ErrorReason reason = ReasonOfRefusal(refusal);
  const int64_t now_ns = clock_.NowNs();
  {
    const std::lock_guard lock(mutex_);
    Line& line = lines_.at(reason);
    if (now_ns < line.next_ns) {
      ++line.left_out_count;
      return;
    }
    line.next_ns = now_ns + kIntervalNs;
  }
  log_.warn("refused {} ({}): {}", std::string(peer), std::string(NameOf(reason)),
            std::string(refusal.message()));
}

void RefusalLog::TellEnd(std::string_view peer, const absl::Status& end) {
  if (end.ok() || absl::IsCancelled(end)) return;
  const v1::ErrorReason reason = ReasonOfRefusal(end);
  if (reason != v1::ERROR_REASON_UNKNOWN_SCENE && reason != v1::ERROR_REASON_DRAINING)
    Tell(peer, end);
}

void RefusalLog::TellLeftOut() {
  const int64_t now_ns = clock_.NowNs();
  std::array<uint64_t, v1::ErrorReason_ARRAYSIZE> left_out_counts{};
  {
    const std::lock_guard lock(mutex_);
    for (size_t reason = 0; reason < lines_.size(); ++reason) {
      Line& line = lines_.at(reason);
      if (line.left_out_count == 0 || now_ns < line.next_ns) continue;
      line.next_ns = now_ns + kIntervalNs;
      left_out_counts.at(reason) = std::exchange(line.left_out_count, 0);
    }
  }
  // Write the lines after releasing the lock: writing may be slow, and other calls wait for the
  // lock.
  for (size_t reason = 0; reason < left_out_counts.size(); ++reason) {
    if (left_out_counts.at(reason) == 0) continue;
    log_.warn("refused {} more calls ({})", left_out_counts.at(reason),
              std::string(NameOf(static_cast<v1::ErrorReason>(reason))));
  }
}

}  // namespace sweepstake::rpc
