#include "server/decision/arm_runs.h"

namespace sweepstake::decision {
namespace {

bool Matches(const ArmRun& run, const Frame& frame) {
  return run.switch_epoch() == frame.switch_epoch && run.arm() == frame.arm;
}

}  // namespace

bool IsLaterEpoch(uint32_t epoch, uint32_t than) {
  return epoch != than && epoch - than < (1u << 31);
}

ArmRun* ArmRuns::Find(const Frame& frame, uint64_t settling_ns) {
  if (frame.arm >= arm_count_) return nullptr;
  if (IsActive(frame)) {
    active_frames_seen_ = true;
    return &active_;
  }
  if (!IsLaterEpoch(frame.switch_epoch, active_.switch_epoch())) return nullptr;
  if (!later_ || IsLaterEpoch(frame.switch_epoch, later_->switch_epoch())) {
    later_.emplace(frame.arm, frame.switch_epoch, settling_ns);
  }
  return Matches(*later_, frame) ? &*later_ : nullptr;
}

bool ArmRuns::IsActive(const Frame& frame) const { return Matches(active_, frame); }

void ArmRuns::Activate(const ArmRun& run) {
  active_ = run;
  later_.reset();
  active_frames_seen_ = false;
}

void ArmRuns::ClearWindow() {
  active_.ClearWindow();
  active_frames_seen_ = false;
}

}  // namespace sweepstake::decision
