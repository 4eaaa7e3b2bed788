#include "server/sessions/common/session_use.h"

#include <utility>

namespace sweepstake::sessions {

void UseMeter::AddFrames(std::span<const FrameSample> frames, int64_t unix_now_ms) {
  for (const FrameSample& frame : frames) {
    if ((frame.flags & kFrameWithoutCost) != 0 || frame.arm >= arm_count_) continue;
    if (is_empty()) use_.unix_start_ms = unix_now_ms;
    use_.frames.Add(frame.frame_time_ns, frame.detection_time_ns, frame.native_bytes);
    ++use_.active_frame_counts[frame.arm];
  }
}

SessionUse UseMeter::Take(const decision::RegimeUse& total, uint32_t initial_arm,
                          int64_t unix_now_ms) {
  reported_.arm_us.resize(total.arm_us.size());
  reported_.known_frame_counts.resize(total.arm_us.size());
  use_.unix_end_ms = unix_now_ms;
  use_.is_first = std::exchange(is_first_, false);
  use_.measured = {.frame_count = total.frame_count - reported_.frame_count,
                   .ran_us = total.ran_us - reported_.ran_us};
  use_.initial_arm = initial_arm;
  for (size_t i = 0; i < total.arm_us.size(); ++i) {
    use_.measured.arm_us.push_back(total.arm_us[i] - reported_.arm_us[i]);
    use_.measured.known_frame_counts.push_back(total.known_frame_counts[i] -
                                               reported_.known_frame_counts[i]);
  }
  reported_ = total;
  SessionUse taken = std::move(use_);
  Begin();
  return taken;
}

}  // namespace sweepstake::sessions
