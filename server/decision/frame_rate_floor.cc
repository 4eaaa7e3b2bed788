#include "server/decision/frame_rate_floor.h"

namespace sweepstake::decision {

void FrameRateFloor::Observe(uint32_t arm, double fps, uint32_t leader) {
  const bool under = fps < floor_fps_;
  missed_[arm] = under;
  if (under && !missed_[leader]) return;
  contrary_count_ = under == degraded_ ? 0 : contrary_count_ + 1;
  if (contrary_count_ < kWindowCount) return;
  degraded_ = under;
  contrary_count_ = 0;
}

}  // namespace sweepstake::decision
