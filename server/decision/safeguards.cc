#include "server/decision/safeguards.h"

#include <algorithm>

namespace sweepstake::decision {

bool IsOverBailOutLimit(const Frame& frame, int64_t bail_out_ns) {
  return frame.frame_time_ns > static_cast<uint64_t>(bail_out_ns) ||
         (frame.flags & kFrameBailOut) != 0;
}

bool BlamesArm(const Frame& frame, int64_t bail_out_ns) {
  if (!IsOverBailOutLimit(frame, bail_out_ns)) return false;
  if ((frame.flags & (kFramePaused | kFrameLoading)) != 0) return false;
  const uint64_t detection_ns = std::min(frame.detection_time_ns, frame.frame_time_ns);
  return detection_ns >= frame.frame_time_ns - detection_ns;
}

bool SwitchGate::CooldownPassed(int64_t now_ns) const {
  if (!last_switch_ns_) return true;
  if (now_ns < *last_switch_ns_) return false;
  // Unsigned, since the two may be further apart than an int64_t holds.
  const uint64_t passed = static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(*last_switch_ns_);
  return passed >= static_cast<uint64_t>(cooldown_ns_);
}

void SwitchGate::OnExecuted(int64_t executed_ns) {
  last_switch_ns_ = executed_ns;
  ticks_since_command_.reset();
}

void SwitchGate::OnTick(bool old_epoch_frames_seen) {
  if (!ticks_since_command_) return;
  ++*ticks_since_command_;
  if (*ticks_since_command_ >= 2 && old_epoch_frames_seen) ticks_since_command_.reset();
}

}  // namespace sweepstake::decision
