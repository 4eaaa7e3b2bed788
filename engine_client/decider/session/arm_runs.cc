#include "engine_client/decider/session/arm_runs.h"

#include "engine_client/math/saturating_sum.h"

namespace sweepstake::decision {
namespace {

bool Matches(const ArmRun& run, const FrameSample& frame) {
  return run.switch_epoch() == frame.switch_epoch && run.arm() == frame.arm;
}

}  // namespace

ArmRun::ArmRun(uint32_t arm, uint32_t switch_epoch, uint64_t settling_ns)
    : arm_(arm), switch_epoch_(switch_epoch), settling_end_ns_(settling_ns) {}

bool ArmRun::Observe(const FrameSample& frame, uint64_t rebuild_settling_ns) {
  if (SettlesAgain(frame, rebuild_settling_ns)) {
    Advance(frame);
    settling_end_ns_ = SaturatingSum(elapsed_ns_, rebuild_settling_ns);
    measured_ns_ = 0;
    settling_frames_seen_ = true;
    return false;
  }
  const bool settles = elapsed_ns_ < settling_end_ns_;
  Advance(frame);
  if (settles) {
    settling_frames_seen_ = true;
    return false;
  }
  measured_ns_ = SaturatingSum(measured_ns_, frame.frame_time_ns);
  new_frames_.Add(frame);
  return true;
}

void ArmRun::Pass(const FrameSample& frame) { Advance(frame); }

void ArmRun::FileNewFrames() {
  if (new_frames_.empty()) return;
  window_.Add(new_frames_);
  new_frames_.Clear();
}

void ArmRun::ClearWindow() {
  window_.Clear();
  settling_frames_seen_ = false;
}

bool ArmRun::SettlesAgain(const FrameSample& frame, uint64_t rebuild_settling_ns) const {
  return (frame.flags & kFrameRebuild) != 0 && rebuild_settling_ns > 0 && started_ &&
         elapsed_ns_ >= settling_end_ns_ && measured_ns_ >= rebuild_settling_ns;
}

void ArmRun::Advance(const FrameSample& frame) {
  if (started_) elapsed_ns_ = SaturatingSum(elapsed_ns_, frame.frame_time_ns);
  started_ = true;
}

bool IsLaterEpoch(uint32_t epoch, uint32_t than) {
  return epoch != than && epoch - than < (1u << 31);
}

ArmRun* ArmRuns::Find(const FrameSample& frame, uint64_t settling_ns) {
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

bool ArmRuns::IsActive(const FrameSample& frame) const { return Matches(active_, frame); }

void ArmRuns::Activate(const ArmRun& run) {
  active_ = run;
  later_.reset();
  active_frames_seen_ = false;
}

void ArmRuns::ObserveDescriptor(DescriptorMatch match) {
  regime_span_.ObserveDescriptor(match);
  for (ArmRun* run : {&active_, later_ ? &*later_ : nullptr}) {
    if (run == nullptr) continue;
    regime_span_.is_in_doubt() ? run->DropNewFrames() : run->FileNewFrames();
  }
}

void ArmRuns::ClearWindow() {
  active_.ClearWindow();
  active_frames_seen_ = false;
}

}  // namespace sweepstake::decision
