#include "engine_client/decider/session/safeguards.h"

#include <algorithm>

#include "engine_client/math/saturating_sum.h"

namespace sweepstake::decision {
namespace {

bool HasPassed(int64_t interval_ns, int64_t since_ns, int64_t now_ns) {
  if (now_ns < since_ns) return false;
  // Unsigned, because the difference can exceed the range of int64_t.
  return static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(since_ns) >=
         static_cast<uint64_t>(interval_ns);
}

}  // namespace

bool IsOverBailOutLimit(const FrameSample& frame, int64_t bail_out_ns) {
  if ((frame.flags & kFrameSuspended) != 0) return false;
  return frame.frame_time_ns > static_cast<uint64_t>(bail_out_ns) ||
         (frame.flags & kFrameBailOut) != 0;
}

bool IsCausedByArm(const FrameSample& frame, int64_t bail_out_ns) {
  return IsOverBailOutLimit(frame, bail_out_ns) && IsCausedByDetection(frame);
}

bool BailOutBudget::HasRoom(int64_t now_ns) const {
  const int64_t max_ahead_ns = (kBurst - 1) * bail_out_ns_;
  return !HasPassed(max_ahead_ns + 1, now_ns, std::max(spent_until_ns_, now_ns));
}

bool BailOutBudget::Spend(int64_t now_ns) {
  if (!HasRoom(now_ns)) return false;
  spent_until_ns_ = SaturatingSum(std::max(spent_until_ns_, now_ns), bail_out_ns_);
  return true;
}

bool SwitchGate::CooldownPassed(int64_t now_ns, int64_t cooldown_ns) const {
  return !last_switch_ns_ || HasPassed(cooldown_ns, *last_switch_ns_, now_ns);
}

void SwitchGate::OnCommand(int64_t now_ns) {
  ticks_since_command_ = 0;
  commanded_ns_ = now_ns;
}

void SwitchGate::OnExecuted(int64_t executed_ns) {
  last_switch_ns_ = executed_ns;
  ticks_since_command_.reset();
}

void SwitchGate::OnTick(bool old_epoch_frames_seen, int64_t now_ns) {
  if (!ticks_since_command_) return;
  ++*ticks_since_command_;
  const bool lost = *ticks_since_command_ >= 2 && old_epoch_frames_seen &&
                    HasPassed(kCommandPatienceNs, commanded_ns_, now_ns);
  if (lost) ticks_since_command_.reset();
}

bool FrameRateFloor::IsMissedIn(const Times& window) const {
  if (floor_fps_ == 0) return false;
  const double longest_ms = 1e3 / floor_fps_;
  return window.frame_ms > longest_ms && (window.frame_ms - window.detection_ms <= longest_ms ||
                                          2 * window.detection_ms >= window.frame_ms);
}

void FrameRateFloor::Observe(uint32_t arm, const Times& window, uint32_t leader) {
  const bool missed = IsMissedIn(window);
  missed_[arm] = missed;
  if (missed && !missed_[leader]) return;
  contrary_count_ = missed == degraded_ ? 0 : contrary_count_ + 1;
  if (contrary_count_ < kWindowCount) return;
  degraded_ = missed;
  contrary_count_ = 0;
}

Verdict SteadyVerdict::Observe(Verdict verdict) {
  if (verdict != latest_) latest_count_ = 0;
  latest_ = verdict;
  ++latest_count_;
  const bool is_due = shown_ == Verdict::kUnknown || verdict == Verdict::kUnknown;
  if (is_due || latest_count_ >= kTickCount) shown_ = verdict;
  return shown_;
}

}  // namespace sweepstake::decision
