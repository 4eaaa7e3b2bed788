#include "server/decision/frame_rate_floor.h"

namespace sweepstake::decision {

void FrameRateFloor::Observe(double fps, bool of_leader) {
  const bool under = fps < floor_fps_;
  if (under && !of_leader) return;
  contrary_count_ = under == degraded_ ? 0 : contrary_count_ + 1;
  if (contrary_count_ < kWindowCount) return;
  degraded_ = under;
  contrary_count_ = 0;
}

}  // namespace sweepstake::decision
