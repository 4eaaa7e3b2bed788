// Tracks which arm runs in each switch epoch. It holds the active run and, as soon as frames of a
// later epoch arrive, the run after it. A run divides its frames into settling and measured ones,
// and keeps the window of the measured ones.
//
// A run's time is frame time. It is 0 at the end of the run's first frame, and each later frame
// adds its frame time. The first frame, which builds the structure, always counts as settling
// unless the settling time is 0.
//
// Not thread-safe. The memory is fixed: if frames of several later epochs arrive, only the latest
// epoch is kept.
#pragma once

#include <cstdint>
#include <optional>

#include "engine_client/decider/regime_span.h"
#include "engine_client/decider/types.h"
#include "engine_client/decider/window.h"

namespace sweepstake::decision {

// The frames of one arm in one switch epoch.
class ArmRun {
 public:
  // Frames that begin before `settling_ns` of the run has passed are settling frames.
  explicit ArmRun(uint32_t arm = 0, uint32_t switch_epoch = 0, uint64_t settling_ns = 0);

  // Adds a frame of this run. Returns true if it was measured, false if it was a settling frame.
  //
  // If `rebuild_settling_ns` > 0, a rebuild of a measured run (the object count changed) starts
  // another settling of that length. The window keeps its frames. This happens only if at least
  // `rebuild_settling_ns` of frame time was measured since the last settling. So settling takes at
  // most half of the time, and an object count that changes all the time does not stop the
  // learning.
  bool Observe(const FrameSample& frame, uint64_t rebuild_settling_ns);
  // Adds a frame's time without measuring the frame, because it was over the bail-out limit.
  void Pass(const FrameSample& frame);

  // Starts settling again, as if the run began with the next frame.
  void Restart(uint64_t settling_ns) { *this = ArmRun(arm_, switch_epoch_, settling_ns); }
  // Adds the new frames to the window of the next tick.
  void FileNewFrames();
  // Drops the new frames: they may belong to several regimes.
  void DropNewFrames() { new_frames_.Clear(); }
  // Begins the window of the next tick. New frames are kept.
  void ClearWindow();

  uint32_t arm() const { return arm_; }
  uint32_t switch_epoch() const { return switch_epoch_; }
  uint64_t elapsed_ns() const { return elapsed_ns_; }
  // The measured frames since the last tick that were filed, and those after them.
  const Window& window() const { return window_; }
  const Window& new_frames() const { return new_frames_; }
  // Returns whether this run had settling frames since the last tick.
  bool settling_frames_seen() const { return settling_frames_seen_; }

  // Calls visit(name, member) for every member, for the audit log (audit/audit_row.h).
  template <typename Self, typename Visit>
  static void VisitFields(Self& run, Visit& visit) {
    auto& [arm, switch_epoch, started, settling_frames_seen, elapsed_ns, settling_end_ns,
           measured_ns, window, new_frames] = run;
    visit("arm", arm);
    visit("switch_epoch", switch_epoch);
    visit("started", started);
    visit("settling_frames_seen", settling_frames_seen);
    visit("elapsed_ns", elapsed_ns);
    visit("settling_end_ns", settling_end_ns);
    visit("measured_ns", measured_ns);
    visit("window", window);
    visit("new_frames", new_frames);
  }

 private:
  bool SettlesAgain(const FrameSample& frame, uint64_t rebuild_settling_ns) const;
  void Advance(const FrameSample& frame);

  uint32_t arm_;
  uint32_t switch_epoch_;
  bool started_ = false;
  bool settling_frames_seen_ = false;
  uint64_t elapsed_ns_ = 0;
  uint64_t settling_end_ns_;
  uint64_t measured_ns_ = 0;  // frame time measured since the last settling
  Window window_;
  Window new_frames_;
};

// Returns whether `epoch` comes after `than`. Epochs are uint32_t and wrap around: the later one is
// ahead by less than half of their range.
bool IsLaterEpoch(uint32_t epoch, uint32_t than);

class ArmRuns {
 public:
  explicit ArmRuns(uint32_t arm_count = 0, ArmRun active = ArmRun())
      : arm_count_(arm_count), active_(active) {}

  // Returns the active or the later run, whichever has the frame's epoch and arm. If its epoch is
  // later than every epoch so far, starts a new later run, which settles for `settling_ns`. Returns
  // null if neither run has the frame's epoch and arm, or if there is no such arm.
  ArmRun* Find(const FrameSample& frame, uint64_t settling_ns);

  ArmRun& active() { return active_; }
  const ArmRun& active() const { return active_; }
  // Returns the run of a later epoch: some of its frames have arrived, but it is not active yet.
  const std::optional<ArmRun>& later() const { return later_; }
  bool IsActive(const FrameSample& frame) const;

  // Makes `run` the active run and drops the later run.
  void Activate(const ArmRun& run);

  // Applies a descriptor: files the new frames in the present regime, or drops them if they may
  // belong to another one.
  void ObserveDescriptor(DescriptorMatch match);
  RegimeSpan& regime_span() { return regime_span_; }
  const RegimeSpan& regime_span() const { return regime_span_; }

  // Begins the window of the next tick.
  void ClearWindow();
  // Returns whether frames of the active run, measured or settling, arrived since the last tick.
  bool active_frames_seen() const { return active_frames_seen_; }

  // Copies the state of `runs`. REQUIRES: both have the same number of arms.
  void Restore(const ArmRuns& runs) {
    active_ = runs.active_;
    later_ = runs.later_;
    active_frames_seen_ = runs.active_frames_seen_;
    regime_span_ = runs.regime_span_;
  }

  // Calls visit(name, member) for every member except the number of arms, for the audit log.
  template <typename Self, typename Visit>
  static void VisitFields(Self& runs, Visit& visit) {
    auto& [arm_count, active, later, active_frames_seen, regime_span] = runs;
    visit("active", active);
    visit("later", later);
    visit("active_frames_seen", active_frames_seen);
    visit("regime_span", regime_span);
  }

 private:
  uint32_t arm_count_;
  ArmRun active_;
  std::optional<ArmRun> later_;
  bool active_frames_seen_ = false;
  RegimeSpan regime_span_;
};

}  // namespace sweepstake::decision
